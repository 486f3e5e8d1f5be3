//! The records of an MCAP file (specification version 0): chunks, indexes, summary. The content of messages is not
//! known here.
//!
//! ```text
//! magic | Header | { Chunk { Schema Channel Message ... } MessageIndex ... } ... | Metadata
//! | DataEnd | Schema ... Channel ... Statistics ChunkIndex ... MetadataIndex | SummaryOffset ... | Footer | magic
//! ```
//!
//! A chunk holds every schema and channel that its messages use, so that it is readable if others are damaged. Memory
//! holds one chunk, the schemas and channels, and one index entry for each chunk. Chunks end at a size, or by the age
//! of live frames, regardless of when the output is taken.

use std::collections::BTreeMap;

/// Size of the records after which a chunk ends, in bytes, uncompressed.
const CHUNK: usize = 1 << 20;
/// Age of a live chunk's messages after which it ends, in ns.
const OLD: u64 = 1_000_000_000;
/// Compression level; 3 is the default of Zstandard.
const LEVEL: i32 = 3;
/// The first and the last bytes of a file.
const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// Opcodes.
mod op {
    pub(super) const HEADER: u8 = 0x01;
    pub(super) const FOOTER: u8 = 0x02;
    pub(super) const SCHEMA: u8 = 0x03;
    pub(super) const CHANNEL: u8 = 0x04;
    pub(super) const MESSAGE: u8 = 0x05;
    pub(super) const CHUNK: u8 = 0x06;
    pub(super) const MESSAGE_INDEX: u8 = 0x07;
    pub(super) const CHUNK_INDEX: u8 = 0x08;
    pub(super) const STATISTICS: u8 = 0x0B;
    pub(super) const METADATA: u8 = 0x0C;
    pub(super) const METADATA_INDEX: u8 = 0x0D;
    pub(super) const SUMMARY_OFFSET: u8 = 0x0E;
    pub(super) const DATA_END: u8 = 0x0F;
}

/// Numbers and strings of records: little-endian, with the length first.
trait Put {
    fn u16(&mut self, number: u16);
    fn u32(&mut self, number: u32);
    fn u64(&mut self, number: u64);
    /// Appends bytes after their 32-bit length.
    fn sized(&mut self, bytes: &[u8]);
}

impl Put for Vec<u8> {
    fn u16(&mut self, number: u16) {
        self.extend_from_slice(&number.to_le_bytes());
    }

    fn u32(&mut self, number: u32) {
        self.extend_from_slice(&number.to_le_bytes());
    }

    fn u64(&mut self, number: u64) {
        self.extend_from_slice(&number.to_le_bytes());
    }

    fn sized(&mut self, bytes: &[u8]) {
        self.u32(bytes.len() as u32);
        self.extend_from_slice(bytes);
    }
}

/// Appends a record.
fn record(out: &mut Vec<u8>, opcode: u8, content: &[u8]) {
    out.push(opcode);
    out.u64(content.len() as u64);
    out.extend_from_slice(content);
}

/// Appends a map of strings after its length in bytes.
fn map(out: &mut Vec<u8>, pairs: &[(&str, &str)]) {
    let mut content = Vec::new();
    for (key, value) in pairs {
        content.sized(key.as_bytes());
        content.sized(value.as_bytes());
    }
    out.sized(&content);
}

/// The record of a schema or channel, and its latest chunk.
#[derive(Debug)]
struct Declared {
    record: Vec<u8>,
    /// The number of the last chunk that holds it, from 1.
    chunk: u64,
}

/// A channel.
#[derive(Debug)]
struct McapChannel {
    declared: Declared,
    schema: u16,
    messages: u64,
    /// Its entries in the current chunk's index.
    index: Vec<u8>,
}

/// The ID of a schema, from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SchemaId(u16);

/// The ID of a channel, from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ChannelId(u16);

/// The first and the last time of a set of messages.
#[derive(Clone, Copy, Debug)]
struct Span(u64, u64);

impl Span {
    fn widen(span: &mut Option<Self>, time: u64) {
        let Self(first, last) = span.get_or_insert(Self(time, time));
        *first = (*first).min(time);
        *last = (*last).max(time);
    }
}

/// A file that is being written.
#[derive(Debug)]
pub(super) struct Container {
    /// True if chunks have an index of their messages.
    indexed: bool,
    /// Number of bytes of the file so far.
    offset: u64,
    schemas: Vec<Declared>,
    channels: Vec<McapChannel>,
    /// Records of the current chunk.
    chunk: Vec<u8>,
    chunk_span: Option<Span>,
    /// The number of the current chunk, from 1.
    chunks: u64,
    /// Records of the summary, one for each chunk.
    chunk_indexes: Vec<u8>,
    metadata: u32,
    metadata_indexes: Vec<u8>,
    messages: u64,
    span: Option<Span>,
}

impl Container {
    /// Creates an empty file.
    pub(super) fn new(indexed: bool) -> Self {
        Self {
            indexed,
            offset: 0,
            schemas: Vec::new(),
            channels: Vec::new(),
            chunk: Vec::new(),
            chunk_span: None,
            chunks: 1,
            chunk_indexes: Vec::new(),
            metadata: 0,
            metadata_indexes: Vec::new(),
            messages: 0,
            span: None,
        }
    }

    /// Returns true if anything has been written.
    pub(super) fn is_begun(&self) -> bool {
        self.offset > 0
    }

    /// Appends the beginning of a file.
    pub(super) fn begin(&mut self, out: &mut Vec<u8>, profile: &str, library: &str) {
        let start = out.len();
        out.extend_from_slice(MAGIC);
        let mut content = Vec::new();
        content.sized(profile.as_bytes());
        content.sized(library.as_bytes());
        record(out, op::HEADER, &content);
        self.offset += (out.len() - start) as u64;
    }

    /// Declares a schema; `None` if no ID is left.
    pub(super) fn schema(&mut self, name: &str, encoding: &str, text: &str) -> Option<SchemaId> {
        let id = u16::try_from(self.schemas.len() + 1).ok()?;
        let mut content = Vec::new();
        content.u16(id);
        content.sized(name.as_bytes());
        content.sized(encoding.as_bytes());
        content.sized(text.as_bytes());
        let mut whole = Vec::new();
        record(&mut whole, op::SCHEMA, &content);
        self.schemas.push(Declared { record: whole, chunk: 0 });
        Some(SchemaId(id))
    }

    /// Declares a channel; `None` if no ID is left.
    pub(super) fn channel(
        &mut self,
        topic: &str,
        schema: SchemaId,
        encoding: &str,
        metadata: &[(&str, &str)],
    ) -> Option<ChannelId> {
        let id = u16::try_from(self.channels.len()).ok()?;
        let mut content = Vec::new();
        content.u16(id);
        content.u16(schema.0);
        content.sized(topic.as_bytes());
        content.sized(encoding.as_bytes());
        map(&mut content, metadata);
        let mut whole = Vec::new();
        record(&mut whole, op::CHANNEL, &content);
        let declared = Declared { record: whole, chunk: 0 };
        self.channels.push(McapChannel { declared, schema: schema.0, messages: 0, index: Vec::new() });
        Some(ChannelId(id))
    }

    /// Adds a message logged and published at `time`, in ns. Appends the chunk when it is full.
    pub(super) fn message(&mut self, out: &mut Vec<u8>, channel: ChannelId, sequence: u32, time: u64, data: &[u8]) {
        let Self { schemas, channels, chunk, chunks, indexed, .. } = self;
        let Some(known) = channels.get_mut(usize::from(channel.0)) else { return };
        if known.declared.chunk != *chunks {
            known.declared.chunk = *chunks;
            if let Some(schema) = schemas.get_mut(usize::from(known.schema).wrapping_sub(1))
                && schema.chunk != *chunks
            {
                schema.chunk = *chunks;
                chunk.extend_from_slice(&schema.record);
            }
            chunk.extend_from_slice(&known.declared.record);
        }
        known.messages += 1;
        if *indexed {
            known.index.u64(time);
            known.index.u64(chunk.len() as u64);
        }
        chunk.push(op::MESSAGE);
        chunk.u64(22 + data.len() as u64);
        chunk.u16(channel.0);
        chunk.u32(sequence);
        chunk.u64(time);
        chunk.u64(time);
        chunk.extend_from_slice(data);
        self.messages += 1;
        Span::widen(&mut self.chunk_span, time);
        Span::widen(&mut self.span, time);
        if self.chunk.len() >= CHUNK {
            self.end_chunk(out);
        }
    }

    /// Appends the current chunk if its messages are old at `time`.
    pub(super) fn until(&mut self, out: &mut Vec<u8>, time: u64) {
        if self.chunk_span.is_some_and(|Span(first, _)| time >= first.saturating_add(OLD)) {
            self.end_chunk(out);
        }
    }

    /// Appends the current chunk and its indexes.
    fn end_chunk(&mut self, out: &mut Vec<u8>) {
        if self.chunk.is_empty() {
            return;
        }
        let start = out.len();
        let Span(first, last) = self.chunk_span.take().unwrap_or(Span(0, 0));
        // Records that the library fails to compress are stored uncompressed.
        let compressed = zstd::bulk::compress(&self.chunk, LEVEL);
        let (compression, records): (&[u8], &[u8]) = match &compressed {
            Ok(compressed) => (b"zstd", compressed),
            Err(_) => (b"", &self.chunk),
        };
        let mut head = Vec::new();
        head.u64(first);
        head.u64(last);
        head.u64(self.chunk.len() as u64);
        head.u32(crc32fast::hash(&self.chunk));
        head.sized(compression);
        head.u64(records.len() as u64);
        out.push(op::CHUNK);
        out.u64((head.len() + records.len()) as u64);
        out.extend_from_slice(&head);
        out.extend_from_slice(records);
        let chunk_end = out.len();

        let mut places = Vec::new();
        for (id, channel) in (0_u16..).zip(&mut self.channels) {
            if channel.index.is_empty() {
                continue;
            }
            places.u16(id);
            places.u64(self.offset + (out.len() - start) as u64);
            let mut content = Vec::new();
            content.u16(id);
            content.sized(&channel.index);
            record(out, op::MESSAGE_INDEX, &content);
            channel.index.clear();
        }

        let mut content = Vec::new();
        content.u64(first);
        content.u64(last);
        content.u64(self.offset);
        content.u64((chunk_end - start) as u64);
        content.sized(&places);
        content.u64((out.len() - chunk_end) as u64);
        content.sized(compression);
        content.u64(records.len() as u64);
        content.u64(self.chunk.len() as u64);
        record(&mut self.chunk_indexes, op::CHUNK_INDEX, &content);
        self.offset += (out.len() - start) as u64;
        self.chunk.clear();
        self.chunks += 1;
    }

    /// Appends a metadata record, after the unfinished chunk.
    pub(super) fn metadata(&mut self, out: &mut Vec<u8>, name: &str, pairs: &[(&str, &str)]) {
        self.end_chunk(out);
        let start = out.len();
        let mut content = Vec::new();
        content.sized(name.as_bytes());
        map(&mut content, pairs);
        record(out, op::METADATA, &content);
        let length = (out.len() - start) as u64;
        let mut content = Vec::new();
        content.u64(self.offset);
        content.u64(length);
        content.sized(name.as_bytes());
        record(&mut self.metadata_indexes, op::METADATA_INDEX, &content);
        self.offset += length;
        self.metadata += 1;
    }

    /// Appends the rest, the summary, and the end of the file.
    pub(super) fn finish(&mut self, out: &mut Vec<u8>) {
        self.end_chunk(out);
        let start = out.len();
        // 0: the data section has no check sum, since every chunk has one.
        record(out, op::DATA_END, &0_u32.to_le_bytes());
        let summary = out.len();
        let summary_start = self.offset + (summary - start) as u64;

        let schemas: Vec<u8> = self.schemas.iter().flat_map(|schema| &schema.record).copied().collect();
        let channels: Vec<u8> = self.channels.iter().flat_map(|channel| &channel.declared.record).copied().collect();
        let mut statistics = Vec::new();
        record(&mut statistics, op::STATISTICS, &self.statistics());
        let groups = [
            (op::SCHEMA, &schemas),
            (op::CHANNEL, &channels),
            (op::STATISTICS, &statistics),
            (op::CHUNK_INDEX, &self.chunk_indexes),
            (op::METADATA_INDEX, &self.metadata_indexes),
        ];
        let mut offsets = Vec::new();
        for (opcode, records) in groups.into_iter().filter(|(_, records)| !records.is_empty()) {
            let mut content = vec![opcode];
            content.u64(self.offset + (out.len() - start) as u64);
            content.u64(records.len() as u64);
            record(&mut offsets, op::SUMMARY_OFFSET, &content);
            out.extend_from_slice(records);
        }
        let offsets_start = self.offset + (out.len() - start) as u64;
        out.extend_from_slice(&offsets);
        out.push(op::FOOTER);
        out.u64(20);
        out.u64(summary_start);
        out.u64(offsets_start);
        // From the beginning of the summary to here.
        let crc = crc32fast::hash(out.get(summary..).unwrap_or(&[]));
        out.u32(crc);
        out.extend_from_slice(MAGIC);
        self.offset += (out.len() - start) as u64;
    }

    fn statistics(&self) -> Vec<u8> {
        let counts: BTreeMap<u16, u64> =
            (0_u16..).zip(&self.channels).map(|(id, channel)| (id, channel.messages)).collect();
        let Span(first, last) = self.span.unwrap_or(Span(0, 0));
        let mut content = Vec::new();
        content.u64(self.messages);
        content.u16(self.schemas.len() as u16);
        content.u32(self.channels.len() as u32);
        content.u32(0);
        content.u32(self.metadata);
        content.u32((self.chunks - 1) as u32);
        content.u64(first);
        content.u64(last);
        let mut places = Vec::new();
        for (id, count) in counts {
            places.u16(id);
            places.u64(count);
        }
        content.sized(&places);
        content
    }
}
