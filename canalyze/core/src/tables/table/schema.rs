//! The schema of the records: the name, the type and the documentation of each column in every form.
//!
//! Apart from [`super`], because no value of a record passes here: the schema and the pages of columns are made of it.
//! Must not: know a record.

use arrow_schema::{DataType, Field};

use super::{InArrow, list};
use crate::tables::columns::column::Column;
use crate::words::digits::put;
use crate::words::escape;

/// Returns the Arrow field of a column.
pub(in crate::tables) fn field<K: InArrow>(name: &str, is_null: bool) -> Field {
    let name = [name.trim_start_matches("r#"), K::SUFFIX].concat();
    Field::new(name, K::Builder::data_type(), is_null)
}

/// A column in the schema.
pub(in crate::tables) struct Row<'a> {
    pub(in crate::tables) name: &'a str,
    /// The key in JSON, or the name of the Arrow column where that is all; empty where `name` is it.
    pub(in crate::tables) key: &'a str,
    pub(in crate::tables) sink: &'a str,
    pub(in crate::tables) is_null: bool,
    pub(in crate::tables) json: &'a str,
    pub(in crate::tables) arrow: Option<Field>,
    /// In English, then in Chinese; nothing where it is one of [`MEANINGS`].
    pub(in crate::tables) documentation: &'a [&'a str],
}

/// Appends the schema of a record: `table` and `kind` are null where there is none; a column has a `column` and an
/// `arrow` type where it is in the table, a `key` and a `json` type where it is in the object.
pub(in crate::tables) fn schema(out: &mut Vec<u8>, [table, kind, en, zh]: [&str; 4], csv: &[&str], rows: &[Row<'_>]) {
    let text = |out: &mut Vec<u8>, key: &str, text: &str| {
        put!(out; key);
        match text {
            "" => put!(out; "null"),
            text => escape::json(out, text.trim().as_bytes()),
        }
    };
    text(out, "{\"table\":", table);
    text(out, ",\"kind\":", kind);
    text(out, ",\"en\":", en);
    text(out, ",\"zh\":", zh);
    put!(out; ",\"csv\":");
    list(out, csv, |out, heading| text(out, "", heading));
    put!(out; ",\"columns\":");
    list(out, rows.iter().filter(|row| row.sink != "csv"), |out, row| {
        let name = row.name.trim_start_matches("r#");
        let named = if row.key.is_empty() { name } else { row.key };
        let common =
            MEANINGS.iter().find(|meaning| meaning.0 == named).map_or(["", ""], |meaning| [meaning.1, meaning.2]);
        let meaning = |place: usize| {
            let own = row.documentation.get(place).copied();
            own.or(common.get(place).copied()).unwrap_or_default()
        };
        let arrow = row.arrow.as_ref();
        let column = arrow.map_or("", |field| if row.sink == "arrow" { named } else { field.name() });
        text(out, "{\"column\":", column);
        text(out, ",\"arrow\":", &arrow.map_or(String::new(), |field| type_name(field.data_type())));
        text(
            out,
            ",\"key\":",
            if row.sink == "arrow" || row.sink == "members" && row.key.is_empty() { "" } else { named },
        );
        text(out, ",\"json\":", if row.sink == "arrow" { "" } else { row.json });
        let truth = |yes: bool| if yes { "true" } else { "false" };
        put!(out; ",\"nullable\":", truth(row.is_null), ",\"optional\":", truth(row.sink == "optional"));
        text(out, ",\"en\":", meaning(0));
        text(out, ",\"zh\":", meaning(1));
        put!(out; "}");
    });
    put!(out; "}");
}

fn type_name(data_type: &DataType) -> String {
    match data_type {
        DataType::Dictionary(..) | DataType::Utf8 => "string".to_owned(),
        DataType::Boolean => "bool".to_owned(),
        DataType::List(field) => format!("list of {}", type_name(field.data_type())),
        other => format!("{other:?}").to_lowercase(),
    }
}

/// The documentation of columns that many records have.
const MEANINGS: &[(&str, &str, &str)] = &[
    ("frame", "number of the frame, from 1", "帧号，从1起"),
    ("line", "line of the file; empty in binary formats", "文件的行号；二进制格式为空"),
    ("file", "name of the file", "文件名"),
    ("t", "timestamp", "时间戳"),
    ("bus", "bus; empty where the capture names none", "总线名；记录中没有时为空"),
    ("node", "node-ID; empty where it is about no node", "节点ID；与节点无关时为空"),
    ("cycle", "number of the SYNC cycle, from 1", "同步周期的编号，从1起"),
    ("index", "index of the object", "对象索引"),
    ("sub", "sub-index", "子索引"),
    ("object", "object, as 1008:00", "对象，如 1008:00"),
    ("name", "name", "名称"),
    ("type", "data type", "数据类型"),
    ("data", "data bytes", "数据字节"),
    ("value", "value, scaled", "换算后的值"),
    ("integer", "value as a signed integer", "值：有符号整数"),
    ("raw", "value as an unsigned number, not scaled", "未换算的无符号值"),
    ("unit", "unit", "单位"),
    ("text", "in words", "文字说明"),
    ("message", "in words", "文字说明"),
    ("facts", "its figures, as JSON", "数值，JSON"),
    ("pdo", "PDO, as TPDO1", "PDO，如 TPDO1"),
    ("service", "service: nmt, sync, pdo, sdo, ...", "服务：nmt、sync、pdo、sdo等"),
    ("severity", "error, warning or info", "error、warning、info"),
    ("source", "the kind of message it comes from", "状态由什么报文得出；log里为来源"),
    ("transfer", "number of the transfer, from 1", "传输编号，从1起"),
    ("findings", "codes of its findings", "相关规则的代码"),
    (
        "provenance",
        "where the mapping comes from: observed (written by SDO), else a description or an option",
        "映射的来源：observed 由SDO写入得出，其余来自设备描述或选项",
    ),
];
