//! A table while its rows come: builders of columns under their names, and the batches that they become.
//!
//! Must not: know CANopen.

use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::Arc;

use arrow_array::builder::{ArrayBuilder, BinaryBuilder, BooleanBuilder, ListBuilder, PrimitiveBuilder, StringBuilder};
use arrow_array::types::Int32Type;
use arrow_array::{ArrayRef, ArrowPrimitiveType, DictionaryArray, RecordBatch, StringArray, new_empty_array};
use arrow_schema::{DataType, Field, Schema, SchemaRef};

/// Most rows of a batch.
pub(super) const ROWS: usize = 65_536;
/// Bytes of text and data after which a batch ends early.
const BYTES: usize = 16 << 20;

/// Rows of one table.
#[derive(Clone, Debug)]
pub struct Batch {
    /// The table's name.
    pub name: Arc<str>,
    /// The rows.
    pub rows: RecordBatch,
}

/// A column of numbers.
pub(in crate::tables) type Numbers<T> = PrimitiveBuilder<T>;

/// Returns bytes as text, with U+FFFD for invalid UTF-8. Valid text, the usual case, is borrowed.
pub(in crate::tables) fn lossy(bytes: &[u8]) -> Cow<'_, str> {
    std::str::from_utf8(bytes).map_or_else(|_| String::from_utf8_lossy(bytes), Cow::Borrowed)
}

/// Distinct words that are looked at one by one before a map is asked.
const FEW: usize = 8;

/// A dictionary-encoded column of words; each is once in a batch, in order of first use.
#[derive(Debug, Default)]
pub(in crate::tables) struct Words {
    keys: PrimitiveBuilder<Int32Type>,
    words: Vec<Box<str>>,
    /// Places of words beyond the first [`FEW`].
    places: HashMap<Box<str>, i32>,
    last: usize,
}

impl Words {
    /// Appends a word.
    pub(in crate::tables) fn word(&mut self, word: &str) {
        let known = |place: &usize| self.words.get(*place).is_some_and(|known| &**known == word);
        let place = if known(&self.last) {
            self.last
        } else {
            let early = self.words.iter().take(FEW).position(|known| &**known == word);
            early.or_else(|| self.places.get(word).map(|place| *place as usize)).unwrap_or_else(|| self.add(word))
        };
        self.last = place;
        self.keys.append_value(place as i32);
    }

    /// Appends a word, or null.
    pub(in crate::tables) fn maybe(&mut self, word: Option<&str>) {
        match word {
            Some(word) => self.word(word),
            None => self.keys.append_null(),
        }
    }

    /// Appends a name from the capture; null where it has none. What is not UTF-8 becomes U+FFFD.
    pub(in crate::tables) fn name(&mut self, bytes: &[u8]) {
        let text = lossy(bytes);
        self.maybe((!text.is_empty()).then_some(&*text));
    }

    fn add(&mut self, word: &str) -> usize {
        let place = self.words.len();
        self.words.push(word.into());
        if place >= FEW {
            self.places.insert(word.into(), place as i32);
        }
        place
    }
}

/// A column that is being built; its type says what it will be.
pub(in crate::tables) trait Column {
    /// Returns a column without values and without memory: there may be many tables.
    fn empty() -> Self;
    /// The column's type.
    fn data_type() -> DataType;
    /// Takes the values out.
    fn take(&mut self) -> ArrayRef;
}

impl<T: ArrowPrimitiveType> Column for Numbers<T> {
    fn empty() -> Self {
        Self::with_capacity(0)
    }

    fn data_type() -> DataType {
        T::DATA_TYPE
    }

    fn take(&mut self) -> ArrayRef {
        Arc::new(self.finish())
    }
}

impl Column for BooleanBuilder {
    fn empty() -> Self {
        Self::with_capacity(0)
    }

    fn data_type() -> DataType {
        DataType::Boolean
    }

    fn take(&mut self) -> ArrayRef {
        Arc::new(self.finish())
    }
}

impl Column for StringBuilder {
    fn empty() -> Self {
        Self::with_capacity(0, 0)
    }

    fn data_type() -> DataType {
        DataType::Utf8
    }

    fn take(&mut self) -> ArrayRef {
        Arc::new(self.finish())
    }
}

impl Column for BinaryBuilder {
    fn empty() -> Self {
        Self::with_capacity(0, 0)
    }

    fn data_type() -> DataType {
        DataType::Binary
    }

    fn take(&mut self) -> ArrayRef {
        Arc::new(self.finish())
    }
}

impl<C: Column + ArrayBuilder> Column for ListBuilder<C> {
    fn empty() -> Self {
        Self::with_capacity(C::empty(), 0)
    }

    fn data_type() -> DataType {
        DataType::List(Arc::new(Field::new_list_field(C::data_type(), true)))
    }

    fn take(&mut self) -> ArrayRef {
        Arc::new(self.finish())
    }
}

impl Column for Words {
    fn empty() -> Self {
        Self::default()
    }

    fn data_type() -> DataType {
        DataType::Dictionary(Box::new(DataType::Int32), Box::new(DataType::Utf8))
    }

    fn take(&mut self) -> ArrayRef {
        let words = std::mem::take(self);
        let mut keys = words.keys;
        let values = StringArray::from_iter_values(&words.words);
        match DictionaryArray::try_new(keys.finish(), Arc::new(values)) {
            Ok(column) => Arc::new(column),
            // Every key is the place of a word: this cannot be. The batch will not hold together without it.
            Err(_) => new_empty_array(&Self::data_type()),
        }
    }
}

/// The columns of a table.
pub(in crate::tables) trait Columns {
    /// Their names and types.
    fn fields(&self) -> Vec<Field>;
    /// Takes the rows out.
    fn arrays(&mut self) -> Vec<ArrayRef>;
}

/// Columns whose table has one name.
pub(in crate::tables) trait Named: Columns + Default {
    /// The name of the table.
    const NAME: &'static str;
}

impl<C: Named> Default for Table<C> {
    fn default() -> Self {
        Self::new(C::NAME, C::default(), &[])
    }
}

/// Columns that take records in a context.
pub(in crate::tables) trait Append<C, R>: Columns {
    /// Appends a record, and returns the bytes of its text and data.
    fn append(&mut self, cx: C, record: R) -> usize;
}

/// The end of batches.
pub(super) trait Ends {
    /// Ends the batch, if it has rows.
    fn flush(&mut self, done: &mut Vec<Batch>);
    /// Ends the last batch, also without rows where none has come out before.
    fn finish(&mut self, done: &mut Vec<Batch>);
}

impl<C: Columns> Ends for Table<C> {
    fn flush(&mut self, done: &mut Vec<Batch>) {
        if self.rows > 0 {
            self.end_batch(done);
        }
    }

    fn finish(&mut self, done: &mut Vec<Batch>) {
        if self.rows > 0 || !self.emitted {
            self.end_batch(done);
        }
    }
}

/// A table that is being built.
#[derive(Debug)]
pub(in crate::tables) struct Table<C> {
    name: Arc<str>,
    schema: SchemaRef,
    /// Its columns; whoever appends to each of them once says so with [`Table::end_row`].
    pub(in crate::tables) columns: C,
    rows: usize,
    bytes: usize,
    /// Some batch has come out, so that the schema is known.
    emitted: bool,
}

impl<C: Columns> Table<C> {
    /// A table without rows. `metadata`: of its schema, beside its name.
    pub(in crate::tables) fn new(name: &str, columns: C, metadata: &[(&str, String)]) -> Self {
        let mut all: HashMap<String, String> =
            metadata.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect();
        all.insert("table".to_owned(), name.to_owned());
        let schema = Arc::new(Schema::new(columns.fields()).with_metadata(all));
        Self { name: Arc::from(name), schema, columns, rows: 0, bytes: 0, emitted: false }
    }

    /// Appends a record.
    pub(in crate::tables) fn row<X, R>(&mut self, done: &mut Vec<Batch>, cx: X, record: R)
    where
        C: Append<X, R>,
    {
        let bytes = self.columns.append(cx, record);
        self.end_row(bytes, done);
    }

    /// Ends a row with this number of bytes of text and data.
    pub(in crate::tables) fn end_row(&mut self, bytes: usize, done: &mut Vec<Batch>) {
        self.rows += 1;
        self.bytes += bytes;
        if self.rows >= ROWS || self.bytes >= BYTES {
            self.flush(done);
        }
    }

    fn end_batch(&mut self, done: &mut Vec<Batch>) {
        (self.rows, self.bytes, self.emitted) = (0, 0, true);
        // Columns of one length and of the types that the schema says: an error cannot be.
        if let Ok(rows) = RecordBatch::try_new(Arc::clone(&self.schema), self.columns.arrays()) {
            done.push(Batch { name: Arc::clone(&self.name), rows });
        }
    }
}
