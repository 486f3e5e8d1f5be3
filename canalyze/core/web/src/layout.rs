//! The layout of Arrow columns in memory, described in JSON.
//!
//! Each column is an object: `type` in Arrow's words (`Dictionary` and `List` alone), `rows`, `offset` of the first of
//! them in bits, where they are bits; `buffers`, pairs of address and length; `nulls`, the same with the offset of its
//! first bit; `values` of a list; `words` of a dictionary.

use arrow_array::Array;
use arrow_array::cast::AsArray;
use arrow_array::types::Int32Type;
use arrow_schema::DataType;
use canalyze_core::tables::columns::Batch;
use serde_json::{Value, json};

/// Returns the layout of batches: their `table`, `rows` and `columns`.
pub fn of(batches: &[Batch]) -> Value {
    let described = batches.iter().map(|batch| {
        let schema = batch.rows.schema();
        let columns = schema.fields().iter().zip(batch.rows.columns());
        let columns: Vec<Value> = columns.map(|(field, values)| column(field.name(), &**values)).collect();
        json!({"table": &*batch.name, "rows": batch.rows.num_rows(), "columns": columns})
    });
    described.collect()
}

fn column(name: &str, values: &dyn Array) -> Value {
    let data = values.to_data();
    let place = |bytes: &[u8]| json!([bytes.as_ptr() as usize, bytes.len()]);
    let nulls =
        data.nulls().map(|nulls| json!([nulls.validity().as_ptr() as usize, nulls.validity().len(), nulls.offset()]));
    let buffers: Vec<Value> = data.buffers().iter().map(|buffer| place(buffer.as_slice())).collect();
    let (kind, words, items) = match values.data_type() {
        DataType::Dictionary(..) => ("Dictionary".to_owned(), words(values), None),
        DataType::List(_) => ("List".to_owned(), None, Some(column("", &**values.as_list::<i32>().values()))),
        other => (other.to_string(), None, None),
    };
    json!({
        "name": name, "type": kind, "rows": data.len(), "offset": data.offset(), "nulls": nulls, "buffers": buffers,
        "words": words, "values": items,
    })
}

/// Returns the words of a dictionary of strings.
fn words(values: &dyn Array) -> Option<Vec<String>> {
    let words = values.as_dictionary_opt::<Int32Type>()?.values().as_string_opt::<i32>()?;
    Some(words.iter().map(|word| word.unwrap_or_default().to_owned()).collect())
}
