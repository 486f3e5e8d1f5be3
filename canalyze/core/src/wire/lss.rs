//! LSS, layer setting services (CiA 305).
//!
//! A frame always has eight bytes, unused ones 0; byte 0 is the command specifier. Master to slave is 7E5, slave to
//! master 7E4. Each command is a row of [`COMMANDS`]. Which slave is in the configuration state, and whether an answer
//! is due, depends on other frames and is the bus's part.

pub mod command;

pub use self::command::{Bound, Command, LssSetting, Part};
use super::prelude::*;

/// BitCheck of a Fastscan that asks for any unconfigured slave.
pub const BIT_CHECK_ANY: u8 = 0x80;
/// The node-ID of a slave that has none.
pub const UNCONFIGURED: u8 = 0xFF;

/// A command.
struct CommandRow {
    specifier: u8,
    from_master: bool,
    name: Bilingual,
    /// The name goes on with the name of the first field.
    of_field: bool,
    /// The end of the name in a line.
    remark: Bilingual,
    /// The JSON key and word of what the specifier selects.
    selects: Option<(&'static str, &'static str)>,
    fields: &'static [FieldRow],
    read: fn([u8; 8]) -> Command,
}

const fn master(
    specifier: u8,
    name: Bilingual,
    fields: &'static [FieldRow],
    read: fn([u8; 8]) -> Command,
) -> CommandRow {
    CommandRow { specifier, from_master: true, name, of_field: false, remark: ("", ""), selects: None, fields, read }
}

const fn slave(
    specifier: u8,
    name: Bilingual,
    fields: &'static [FieldRow],
    read: fn([u8; 8]) -> Command,
) -> CommandRow {
    CommandRow { from_master: false, ..master(specifier, name, fields, read) }
}

impl CommandRow {
    const fn of_field(self) -> Self {
        Self { of_field: true, ..self }
    }

    const fn remark(self, zh: &'static str, en: &'static str) -> Self {
        Self { remark: (zh, en), ..self }
    }

    const fn selects(self, key: &'static str, word: &'static str) -> Self {
        Self { selects: Some((key, word)), ..self }
    }
}

const VENDOR: Bilingual = ("制造商ID", "vendor-ID");
const PRODUCT: Bilingual = ("产品码", "product code");
const REVISION: Bilingual = ("修订号", "revision number");
const SERIAL: Bilingual = ("序列号", "serial number");
const REVISION_LOW: Bilingual = ("修订号下限", "revision number, low");
const REVISION_HIGH: Bilingual = ("修订号上限", "revision number, high");
const SERIAL_LOW: Bilingual = ("序列号下限", "serial number, low");
const SERIAL_HIGH: Bilingual = ("序列号上限", "serial number, high");

/// Parts of the LSS address.
static PARTS: &[Term<u8>] =
    &[(0, VENDOR.0, VENDOR.1), (1, PRODUCT.0, PRODUCT.1), (2, REVISION.0, REVISION.1), (3, SERIAL.0, SERIAL.1)];
static MODES: &[Term<u8>] = &[(0, "等待状态", "waiting state"), (1, "配置状态", "configuration state")];
static NODE_ID_ERRORS: &[Term<u8>] = words!("lss_node_id_errors");
static BIT_TIMING_ERRORS: &[Term<u8>] = words!("lss_bit_timing_errors");
static STORE_ERRORS: &[Term<u8>] = words!("lss_store_errors");
const UNKNOWN: Bilingual = ("未知", "unknown");
const STORE: Bilingual = ("存储配置", "store configuration");
const SELECTIVE: Bilingual = ("选择性切换状态", "switch state selective");
const IDENTIFY: Bilingual = ("识别从站", "identify remote slave");

const fn byte(at: usize, name: Bilingual, shown: Breakdown, json: &'static [JsonKey]) -> FieldRow {
    field(at, 1, name, shown, json)
}

const fn number(name: Bilingual) -> FieldRow {
    field(1, 4, name, Little, &[JsonKey::Hex("value")])
}

const MODE: FieldRow = byte(1, ("模式", "mode"), Word(MODES, ("保留", "reserved")), &[JsonKey::Decimal("mode")]);
const NEW_NODE: FieldRow = byte(1, ("", ""), Only(node), &[JsonKey::Decimal("new_node")]);
const NODE: FieldRow = byte(1, ("", ""), Only(node), &[JsonKey::Decimal("node")]);
const SELECTOR: FieldRow = byte(1, ("表选择", "table selector"), With(table), &[JsonKey::Decimal("selector")]);
const INDEX: FieldRow = byte(
    2,
    ("表内序号", "table index"),
    With(rate),
    &[JsonKey::Decimal("index"), JsonKey::With(|object, read| object.maybe("kbit_s", cia_rate(read)))],
);
const DELAY: FieldRow = field(1, 2, ("切换延迟", "switch delay"), With(delay), &[JsonKey::Decimal("delay_ms")]);
const ERROR: FieldRow = byte(
    1,
    ("错误码", "error code"),
    With(|out, lang, read| put!(out; ": ", error(lang, read).unwrap_or(lang.word(UNKNOWN)))),
    &[JsonKey::Decimal("error"), JsonKey::With(|object, read| object.optional("error_name", error(Lang::En, read)))],
);
const SPECIFIC: FieldRow = byte(
    2,
    ("特定错误码 (错误码为FFh时有效)", "specific error code (valid where the error code is FFh)"),
    Name,
    &[JsonKey::Decimal("specific")],
);
const ID_NUMBER: FieldRow = field(1, 4, ("IDNumber", "IDNumber"), Little, &[JsonKey::Hex("id_number")]);
const BIT_CHECK: FieldRow = byte(5, ("BitCheck", "BitCheck"), With(bit_check), &[JsonKey::Hex("bit_check")]);
const SUB: FieldRow = byte(6, ("LSSSub", "LSSSub"), Word(PARTS, UNKNOWN), &[JsonKey::Decimal("lss_sub")]);
const NEXT: FieldRow = byte(7, ("LSSNext", "LSSNext"), Word(PARTS, UNKNOWN), &[JsonKey::Decimal("lss_next")]);

/// The commands by their specifiers.
static COMMANDS: &[CommandRow] = &[
    master(0x04, ("全局切换状态", "switch state global"), &[MODE], |[_, mode, ..]| Command::SwitchGlobal {
        mode,
    }),
    master(0x11, ("配置节点ID", "configure node-ID"), &[NEW_NODE], |[_, node, ..]| Command::ConfigureNodeId {
        node,
    }),
    slave(0x11, ("配置节点ID响应", "configure node-ID response"), &[ERROR, SPECIFIC], |f| {
        confirms(LssSetting::NodeId, f)
    })
    .selects("confirms", "node_id"),
    master(0x13, ("配置位定时", "configure bit timing"), &[SELECTOR, INDEX], |[_, selector, index, ..]| {
        Command::ConfigureBitTiming { selector, index }
    }),
    slave(0x13, ("配置位定时响应", "configure bit timing response"), &[ERROR, SPECIFIC], |f| {
        confirms(LssSetting::BitTiming, f)
    })
    .selects("confirms", "bit_timing"),
    master(0x15, ("激活位定时", "activate bit timing"), &[DELAY], |[_, low, high, ..]| {
        Command::ActivateBitTiming { delay: u16::from_le_bytes([low, high]) }
    }),
    master(0x17, STORE, &[], |_| Command::Store),
    slave(0x17, ("存储配置响应", "store configuration response"), &[ERROR, SPECIFIC], |f| {
        confirms(LssSetting::Store, f)
    })
    .selects("confirms", "store"),
    master(0x40, SELECTIVE, &[number(VENDOR)], |f| selects(Part::Vendor, f)).of_field().selects("part", "vendor"),
    master(0x41, SELECTIVE, &[number(PRODUCT)], |f| selects(Part::Product, f)).of_field().selects("part", "product"),
    master(0x42, SELECTIVE, &[number(REVISION)], |f| selects(Part::Revision, f)).of_field().selects("part", "revision"),
    master(0x43, SELECTIVE, &[number(SERIAL)], |f| selects(Part::Serial, f)).of_field().selects("part", "serial"),
    slave(0x44, ("选择性切换状态响应", "switch state selective response"), &[], |_| {
        Command::SwitchSelectiveResponse
    })
    .remark(" (已进入配置状态)", " (in configuration state)"),
    master(0x46, IDENTIFY, &[number(VENDOR)], |f| bounds(Bound::Vendor, f)).of_field().selects("bound", "vendor"),
    master(0x47, IDENTIFY, &[number(PRODUCT)], |f| bounds(Bound::Product, f)).of_field().selects("bound", "product"),
    master(0x48, IDENTIFY, &[number(REVISION_LOW)], |f| bounds(Bound::RevisionLow, f))
        .of_field()
        .selects("bound", "revision_low"),
    master(0x49, IDENTIFY, &[number(REVISION_HIGH)], |f| bounds(Bound::RevisionHigh, f))
        .of_field()
        .selects("bound", "revision_high"),
    master(0x4A, IDENTIFY, &[number(SERIAL_LOW)], |f| bounds(Bound::SerialLow, f))
        .of_field()
        .selects("bound", "serial_low"),
    master(0x4B, IDENTIFY, &[number(SERIAL_HIGH)], |f| bounds(Bound::SerialHigh, f))
        .of_field()
        .selects("bound", "serial_high"),
    master(0x4C, ("识别未配置的从站", "identify non-configured remote slave"), &[], |_| {
        Command::IdentifyNonConfigured
    }),
    slave(0x4F, ("从站识别响应", "identify slave"), &[], |_| Command::IdentifySlave),
    slave(0x50, ("未配置从站的识别响应", "identify non-configured slave"), &[], |_| {
        Command::IdentifyNonConfiguredSlave
    }),
    master(0x51, ("快速扫描", "Fastscan"), &[ID_NUMBER, BIT_CHECK, SUB, NEXT], |f| {
        let [.., bit_check, sub, next] = f;
        Command::Fastscan { id_number: value(f), bit_check, sub, next }
    })
    .remark("(Fastscan)", ""),
    master(0x5A, ("查询制造商ID", "inquire vendor-ID"), &[], |_| Command::Inquire { part: Part::Vendor })
        .selects("part", "vendor"),
    slave(0x5A, ("制造商ID查询响应", "inquire response, vendor-ID"), &[number(VENDOR)], |f| {
        answers(Part::Vendor, f)
    })
    .selects("part", "vendor"),
    master(0x5B, ("查询产品码", "inquire product code"), &[], |_| Command::Inquire { part: Part::Product })
        .selects("part", "product"),
    slave(0x5B, ("产品码查询响应", "inquire response, product code"), &[number(PRODUCT)], |f| {
        answers(Part::Product, f)
    })
    .selects("part", "product"),
    master(0x5C, ("查询修订号", "inquire revision number"), &[], |_| Command::Inquire { part: Part::Revision })
        .selects("part", "revision"),
    slave(0x5C, ("修订号查询响应", "inquire response, revision number"), &[number(REVISION)], |f| {
        answers(Part::Revision, f)
    })
    .selects("part", "revision"),
    master(0x5D, ("查询序列号", "inquire serial number"), &[], |_| Command::Inquire { part: Part::Serial })
        .selects("part", "serial"),
    slave(0x5D, ("序列号查询响应", "inquire response, serial number"), &[number(SERIAL)], |f| {
        answers(Part::Serial, f)
    })
    .selects("part", "serial"),
    master(0x5E, ("查询节点ID", "inquire node-ID"), &[], |_| Command::InquireNodeId),
    slave(0x5E, ("节点ID查询响应", "inquire response, node-ID"), &[NODE], |[_, node, ..]| {
        Command::InquireNodeIdResponse { node }
    }),
];

fn value([_, a, b, c, d, ..]: [u8; 8]) -> u32 {
    u32::from_le_bytes([a, b, c, d])
}

fn confirms(of: LssSetting, [_, error, specific, ..]: [u8; 8]) -> Command {
    Command::Confirmation { of, error, specific }
}

fn selects(part: Part, frame: [u8; 8]) -> Command {
    Command::SwitchSelective { part, value: value(frame) }
}

fn bounds(bound: Bound, frame: [u8; 8]) -> Command {
    Command::Identify { bound, value: value(frame) }
}

fn answers(part: Part, frame: [u8; 8]) -> Command {
    Command::InquireResponse { part, value: value(frame) }
}

/// Returns the row of a command specifier in one direction.
fn row(from_master: bool, specifier: u8) -> Option<&'static CommandRow> {
    COMMANDS.iter().find(|row| row.from_master == from_master && row.specifier == specifier)
}

/// Returns the bit rate in kbit/s of an index into CiA's bit timing table (selector 0). `None` for 5 (reserved), for 9
/// (automatic detection) and above.
pub const fn bit_rate(index: u8) -> Option<u16> {
    match index {
        0 => Some(1000),
        1 => Some(800),
        2 => Some(500),
        3 => Some(250),
        4 => Some(125),
        6 => Some(50),
        7 => Some(20),
        8 => Some(10),
        _ => None,
    }
}

/// Returns true if the bytes that a defined command does not use are 0, as CiA 305 demands. Other traffic rarely has
/// this form.
pub fn is_plain(from_master: bool, payload: &[u8]) -> bool {
    let row = payload.first().and_then(|specifier| row(from_master, *specifier));
    let unused = row.and_then(|row| payload.get(fields::end(row.fields).max(1)..));
    payload.len() == 8 && unused.is_some_and(|unused| unused.iter().all(|byte| *byte == 0))
}

/// Decodes a frame on 7E5 (`from_master`) or 7E4.
pub fn decode(role: Role, from_master: bool, payload: &[u8]) -> Message {
    let Ok(frame @ [specifier, ..]) = <[u8; 8]>::try_from(payload) else {
        return length(role, 8, 8);
    };
    let command = row(from_master, specifier).map_or(Command::Unknown(specifier), |row| (row.read)(frame));
    Message::Lss { from_master, command }
}

/// Returns the name of a command specifier; of a command and its answer, the command's.
pub fn command(lang: Lang, specifier: u8) -> Option<impl Put> {
    let row = COMMANDS.iter().find(|row| row.specifier == specifier)?;
    Some(move |out: &mut Vec<u8>| {
        put!(out; lang.word(row.name));
        if let (true, Some(field)) = (row.of_field, row.fields.first()) {
            put!(out; lang.pick("(", " ("), lang.word(field.name), ")");
        }
    })
}

/// Returns the name of a part of the address.
pub fn part(lang: Lang, part: Part) -> &'static str {
    find(PARTS, lang, part.number()).unwrap_or_default()
}

/// Returns the meaning of an error code in the answer to a command specifier.
pub fn error_of(lang: Lang, specifier: u8, code: u8) -> Option<&'static str> {
    let errors = match specifier {
        0x11 => NODE_ID_ERRORS,
        0x13 => BIT_TIMING_ERRORS,
        0x17 => STORE_ERRORS,
        _ => return None,
    };
    find(errors, lang, code)
}

fn error(lang: Lang, read: &FieldValue<'_>) -> Option<&'static str> {
    error_of(lang, *read.payload.first()?, read.byte())
}

/// The forms of an LSS frame.
pub(super) struct LssService;

impl WireService for LssService {
    fn line(&self, out: &mut Vec<u8>, lang: Lang, full: bool, message: &Message, frame: &Frame) {
        let Message::Lss { from_master, command } = *message else { return };
        let [specifier, ..] = frame.head();
        phrase(out, lang, from_master, specifier);
        if full {
            content(out, lang, specifier, command);
        }
    }

    fn breakdown(&self, out: &mut Vec<u8>, lang: Lang, message: &Message, frame: &Frame) {
        let Message::Lss { from_master, .. } = *message else { return };
        let [specifier, rest @ ..] = frame.head();
        put!(out; "#   ", Hex::<2>(u64::from(specifier)), lang.pick("  命令字: ", "  command specifier: "));
        phrase(out, lang, from_master, specifier);
        put!(out; "\n");
        match row(from_master, specifier) {
            Some(row) => fields::breakdown_from(out, lang, 1, row.fields, message, frame),
            None => fields::data(out, lang, &rest),
        }
    }

    fn json(&self, object: &mut Object<'_>, message: &Message, frame: &Frame) {
        let Message::Lss { from_master, .. } = *message else { return };
        let [specifier, ..] = frame.head();
        object.word("from", if from_master { "master" } else { "slave" });
        object.hex::<2>("command", u64::from(specifier));
        let Some(row) = row(from_master, specifier) else { return };
        if let Some((key, word)) = row.selects {
            object.word(key, word);
        }
        fields::json(object, row.fields, message, frame);
    }
}

/// Appends the sender and the name of its command.
fn phrase(out: &mut Vec<u8>, lang: Lang, from_master: bool, specifier: u8) {
    put!(out; if from_master { lang.pick("LSS主站: ", "LSS master: ") } else { lang.pick("LSS从站: ", "LSS slave: ") });
    let Some(row) = row(from_master, specifier) else {
        return put!(out; lang.pick("未知命令字 ", "unknown command specifier "), Hex::<2>(u64::from(specifier)), "h");
    };
    put!(out; lang.word(row.name));
    if let (true, Some(field)) = (row.of_field, row.fields.first()) {
        put!(out; ", ", lang.word(field.name));
    }
    put!(out; lang.word(row.remark));
}

/// Appends the values behind the phrase of a line.
fn content(out: &mut Vec<u8>, lang: Lang, specifier: u8, command: Command) {
    match command {
        Command::SwitchGlobal { mode } => match find(MODES, lang, mode) {
            Some(word) => put!(out; ": ", word),
            None => put!(out; lang.pick(": 保留的模式 ", ": reserved mode "), Hex::<2>(u64::from(mode)), "h"),
        },
        Command::SwitchSelective { value, .. }
        | Command::Identify { value, .. }
        | Command::InquireResponse { value, .. } => put!(out; " = ", Hex::<8>(u64::from(value)), "h"),
        Command::ConfigureNodeId { node } | Command::InquireNodeIdResponse { node } => match node {
            1..=127 => put!(out; " = ", node),
            UNCONFIGURED => put!(out; lang.pick(" = FFh (未配置)", " = FFh (unconfigured)")),
            _ => put!(out; " = ", node, lang.pick(" (无效)", " (invalid)")),
        },
        Command::ConfigureBitTiming { selector, index } => bit_timing(out, lang, selector, index),
        Command::Confirmation { error, specific, .. } => confirmation(out, lang, specifier, error, specific),
        Command::ActivateBitTiming { delay } => {
            put!(out; lang.pick(": 切换延迟=", ": switch delay="), delay, " ms");
        }
        Command::Fastscan { id_number, bit_check, sub, next } => fastscan(out, lang, id_number, bit_check, sub, next),
        _ => {}
    }
}

fn bit_timing(out: &mut Vec<u8>, lang: Lang, selector: u8, index: u8) {
    put!(out; ": ");
    match (selector, bit_rate(index)) {
        (0, Some(rate)) => put!(out; lang.pick("波特率 ", "bit rate "), rate, " kbit/s"),
        (0, None) if index == 9 => say!(out, lang; zh: "自动检测波特率"; en: "automatic bit rate detection"),
        (0, None) => say!(out, lang; zh: "保留的波特率"; en: "reserved bit rate"),
        _ => put!(out; table_name(lang, selector)),
    }
    say!(out, lang; zh: " (表=", selector, ", 序号=", index, ")"; en: " (table=", selector, ", index=", index, ")");
}

fn confirmation(out: &mut Vec<u8>, lang: Lang, specifier: u8, error: u8, specific: u8) {
    let reserved = lang.pick("保留的错误码", "reserved error code");
    put!(out; ": ", error_of(lang, specifier, error).unwrap_or(reserved));
    if error != 0 {
        put!(out; lang.pick(" (错误码 ", " (error code "), Hex::<2>(u64::from(error)), "h");
        if error == 0xFF {
            put!(out; lang.pick(", 特定错误码 ", ", specific error code "), Hex::<2>(u64::from(specific)), "h");
        }
        put!(out; ")");
    }
}

fn fastscan(out: &mut Vec<u8>, lang: Lang, id_number: u32, bit_check: u8, sub: u8, next: u8) {
    let part =
        |number| find(PARTS, lang, number).unwrap_or(lang.pick("无效的LSS地址部分", "invalid part of the LSS address"));
    put!(out; ": ");
    match bit_check {
        BIT_CHECK_ANY => compared(out, lang, bit_check),
        32.. => say!(out, lang; zh: "无效的BitCheck"; en: "invalid BitCheck"),
        _ => {
            put!(out; part(sub), ", ");
            compared(out, lang, bit_check);
            if sub != next && bit_check == 0 {
                put!(out; lang.pick(", 确认并转到", ", confirm and continue with "), part(next));
            }
        }
    }
    put!(out; " (IDNumber=", Hex::<8>(u64::from(id_number)), "h, BitCheck=");
    match bit_check {
        32.. => put!(out; Hex::<2>(u64::from(bit_check)), "h"),
        _ => put!(out; bit_check),
    }
    put!(out; ", LSSSub=", sub, ", LSSNext=", next, ")");
}

/// Appends the bits of the address that a Fastscan compares.
fn compared(out: &mut Vec<u8>, lang: Lang, bit_check: u8) {
    match bit_check {
        BIT_CHECK_ANY => say!(out, lang; zh: "询问是否有未配置的从站"; en: "is there any non-configured slave?"),
        32.. => say!(out, lang; zh: "无效"; en: "invalid"),
        31 => say!(out, lang; zh: "比较位31"; en: "compare bit 31"),
        _ => say!(out, lang; zh: "比较位31-", bit_check; en: "compare bits 31-", bit_check),
    }
}

fn bit_check(out: &mut Vec<u8>, lang: Lang, read: &FieldValue<'_>) {
    put!(out; ": ");
    compared(out, lang, read.byte());
}

fn node(out: &mut Vec<u8>, lang: Lang, read: &FieldValue<'_>) {
    match read.byte() {
        UNCONFIGURED => say!(out, lang; zh: "  节点ID FFh: 未配置"; en: "  node-ID FFh: unconfigured"),
        0 => say!(out, lang; zh: "  节点ID 00h (0) 无效"; en: "  node-ID 00h (0) invalid"),
        node => fields::node_id(out, lang, node),
    }
}

fn table_name(lang: Lang, selector: u8) -> &'static str {
    match selector {
        0 => lang.pick("CiA位定时表", "CiA bit timing table"),
        1..128 => lang.pick("保留的位定时表", "reserved bit timing table"),
        128.. => lang.pick("制造商定义的位定时表", "manufacturer-specific bit timing table"),
    }
}

fn table(out: &mut Vec<u8>, lang: Lang, read: &FieldValue<'_>) {
    put!(out; ": ", table_name(lang, read.byte()));
}

/// Returns the bit rate of an index if the selector before it names CiA's table.
fn cia_rate(read: &FieldValue<'_>) -> Option<u16> {
    bit_rate(read.byte()).filter(|_| read.payload.get(1) == Some(&0))
}

fn rate(out: &mut Vec<u8>, lang: Lang, read: &FieldValue<'_>) {
    put!(out; ": ", read.value);
    match cia_rate(read) {
        Some(rate) => put!(out; " = ", rate, " kbit/s"),
        None if read.payload.get(1) != Some(&0) => {}
        None if read.value == 9 => say!(out, lang; zh: " = 自动检测"; en: " = automatic detection"),
        None => say!(out, lang; zh: " = 保留"; en: " = reserved"),
    }
}

fn delay(out: &mut Vec<u8>, lang: Lang, read: &FieldValue<'_>) {
    put!(out; " ", Hex::<4>(u64::from(read.value)), "h = ", read.value, lang.pick(" ms (小端格式)", " ms (little-endian)"));
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
    use super::*;
    use crate::words::lang::tests::sound;

    fn command(from_master: bool, payload: [u8; 8]) -> Command {
        let role = if from_master { Role::LssRequest } else { Role::LssResponse };
        match decode(role, from_master, &payload) {
            Message::Lss { command, .. } => command,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn configuration_session() {
        let master = |payload| command(true, payload);
        assert_eq!(master([0x04, 1, 0, 0, 0, 0, 0, 0]), Command::SwitchGlobal { mode: 1 });
        assert_eq!(master([0x11, 0x0A, 0, 0, 0, 0, 0, 0]), Command::ConfigureNodeId { node: 10 });
        assert_eq!(master([0x13, 0, 2, 0, 0, 0, 0, 0]), Command::ConfigureBitTiming { selector: 0, index: 2 });
        assert_eq!(bit_rate(2), Some(500));
        assert_eq!(master([0x15, 0xE8, 0x03, 0, 0, 0, 0, 0]), Command::ActivateBitTiming { delay: 1000 });
        assert_eq!(master([0x17, 0, 0, 0, 0, 0, 0, 0]), Command::Store);
        assert_eq!(
            master([0x40, 0x78, 0x56, 0x34, 0x12, 0, 0, 0]),
            Command::SwitchSelective { part: Part::Vendor, value: 0x1234_5678 }
        );
        assert_eq!(
            command(false, [0x11, 1, 0, 0, 0, 0, 0, 0]),
            Command::Confirmation { of: LssSetting::NodeId, error: 1, specific: 0 }
        );
    }

    #[test]
    fn fastscan() {
        let fastscan = |id_number, bit_check, sub, next| Command::Fastscan { id_number, bit_check, sub, next };
        assert_eq!(command(true, [0x51, 0, 0, 0, 0, 0x80, 0, 0]), fastscan(0, BIT_CHECK_ANY, 0, 0));
        assert_eq!(command(true, [0x51, 0, 0, 0, 0, 0x1F, 0, 0]), fastscan(0, 31, 0, 0));
        assert_eq!(command(true, [0x51, 1, 0, 0, 0, 0, 0, 1]), fastscan(1, 0, 0, 1));
        assert_eq!(command(true, [0x51, 3, 0, 0, 0, 0, 3, 0]), fastscan(3, 0, 3, 0));
        assert_eq!(command(false, [0x4F, 0, 0, 0, 0, 0, 0, 0]), Command::IdentifySlave);
    }

    #[test]
    fn terms() {
        for terms in [PARTS, MODES, NODE_ID_ERRORS, BIT_TIMING_ERRORS, STORE_ERRORS] {
            sound(terms);
        }
        let parts: Vec<_> = PARTS.iter().map(|part| part.1).collect();
        assert_eq!(parts, ["制造商ID", "产品码", "修订号", "序列号"]);
    }

    #[test]
    fn unused_bytes() {
        assert!(is_plain(true, &[0x04, 1, 0, 0, 0, 0, 0, 0]));
        assert!(!is_plain(true, &[0x04, 1, 1, 0, 0, 0, 0, 0]));
        assert!(is_plain(true, &[0x51, 1, 2, 3, 4, 5, 6, 7]));
        assert!(is_plain(false, &[0x5A, 1, 2, 3, 4, 0, 0, 0]));
        assert!(!is_plain(false, &[0x40, 0, 0, 0, 0, 0, 0, 0]));
        assert!(!is_plain(false, &[0x44]));
    }

    #[test]
    fn direction_decides() {
        assert_eq!(command(true, [0x4F, 0, 0, 0, 0, 0, 0, 0]), Command::Unknown(0x4F));
        assert_eq!(command(false, [0x04, 0, 0, 0, 0, 0, 0, 0]), Command::Unknown(0x04));
        assert_eq!(command(false, [0x5E, 0xFF, 0, 0, 0, 0, 0, 0]), Command::InquireNodeIdResponse { node: 255 });
        assert_eq!(decode(Role::LssRequest, true, &[0x04, 1]), length(Role::LssRequest, 8, 8));
    }
}
