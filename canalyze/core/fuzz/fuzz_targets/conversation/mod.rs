//! SDO transfers of known truth as frames (CiA 301, 7.2.4.3), built from arbitrary bytes.
//!
//! Both sides keep to the protocol, or abort. It must not use the code under test: what a frame is and what a transfer
//! moves is known here from how it was made.

pub mod cut;
pub mod law;

/// The nodes that talk; each has its default channel.
const NODES: [u16; 2] = [10, 33];
/// Objects of any size that are moved, and those of one and of two bytes.
const OBJECTS: [(u16, u8); 6] = [(0x1008, 0), (0x2000, 1), (0x2101, 3), (0x1F50, 1), (0x3210, 0), (0x5000, 0)];
const OF_ONE_BYTE: (u16, u8) = (0x6061, 0);
const OF_TWO_BYTES: (u16, u8) = (0x6041, 0);
const BLOCK_SIZES: [u8; 8] = [1, 2, 5, 16, 64, 127, 3, 33];
/// Seven bytes of data each that look like commands, or with another byte before them like segments.
const LIKE_COMMANDS: [u8; 8] = [0x40, 0x2F, 0x60, 0x43, 0x80, 0xA1, 0xC1, 0xA2];
const MOST_TRANSFERS: usize = 6;
const LONGEST: usize = 1500;
const MICROSECOND_NS: i64 = 1_000;

/// The input, of which any number of bytes can be taken: behind its end they are 0.
pub struct Input<'a>(pub &'a [u8]);

impl Input<'_> {
    pub fn byte(&mut self) -> u8 {
        let Some((first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        *first
    }

    pub fn word(&mut self) -> usize {
        usize::from(self.byte()) << 8 | usize::from(self.byte())
    }

    /// A number below `count`, which is not 0.
    pub fn below(&mut self, count: usize) -> usize {
        self.word() % count
    }

    pub fn one_of<T: Copy>(&mut self, all: &[T]) -> T {
        all[usize::from(self.byte()) % all.len()]
    }
}

/// What one transfer is.
#[derive(Clone, Debug)]
pub struct Truth {
    pub upload: bool,
    pub mode: &'static str,
    pub object: (u16, u8),
    pub data: Vec<u8>,
    pub abort: Option<u32>,
}

/// A frame, and what it is.
#[derive(Clone, Debug)]
pub struct Sent {
    pub t_ns: i64,
    pub id: u16,
    pub data: Vec<u8>,
    /// Which transfer it belongs to; none: it is a heartbeat.
    pub transfer: Option<usize>,
    /// The word for the command in machine output.
    pub command: &'static str,
}

impl Sent {
    pub fn is_client(&self) -> bool {
        self.id & 0x780 == 0x600
    }
}

/// A transfer while its frames are made: who sends, the bytes, the word for the command.
type Frames = Vec<(bool, [u8; 8], &'static str)>;

const CLIENT: bool = true;
const SERVER: bool = false;

fn initiate(command: u8, (index, sub): (u16, u8), tail: [u8; 4]) -> [u8; 8] {
    let [low, high] = index.to_le_bytes();
    let [a, b, c, d] = tail;
    [command, low, high, sub, a, b, c, d]
}

fn with_data(command: u8, part: &[u8]) -> [u8; 8] {
    let mut bytes = [command, 0, 0, 0, 0, 0, 0, 0];
    bytes[1..=part.len()].copy_from_slice(part);
    bytes
}

fn crc(data: &[u8]) -> u16 {
    data.iter().fold(0, |crc, byte| {
        (0..8).fold(
            crc ^ u16::from(*byte) << 8,
            |crc: u16, _| if crc & 0x8000 == 0 { crc << 1 } else { crc << 1 ^ 0x1021 },
        )
    })
}

fn expedited(truth: &Truth) -> Frames {
    let mut tail = [0; 4];
    tail[..truth.data.len()].copy_from_slice(&truth.data);
    let unused = (4 - truth.data.len() as u8) << 2;
    if truth.upload {
        vec![
            (CLIENT, initiate(0x40, truth.object, [0; 4]), "initiate_upload_request"),
            (SERVER, initiate(0x43 | unused, truth.object, tail), "initiate_upload_response"),
        ]
    } else {
        vec![
            (CLIENT, initiate(0x23 | unused, truth.object, tail), "initiate_download_request"),
            (SERVER, initiate(0x60, truth.object, [0; 4]), "initiate_download_response"),
        ]
    }
}

fn segmented(truth: &Truth) -> Frames {
    let size = (truth.data.len() as u32).to_le_bytes();
    let mut frames = if truth.upload {
        vec![
            (CLIENT, initiate(0x40, truth.object, [0; 4]), "initiate_upload_request"),
            (SERVER, initiate(0x41, truth.object, size), "initiate_upload_response"),
        ]
    } else {
        vec![
            (CLIENT, initiate(0x21, truth.object, size), "initiate_download_request"),
            (SERVER, initiate(0x60, truth.object, [0; 4]), "initiate_download_response"),
        ]
    };
    let parts: Vec<&[u8]> = truth.data.chunks(7).collect();
    for (number, part) in parts.iter().enumerate() {
        let toggle = (number as u8 & 1) << 4;
        let command = toggle | (7 - part.len() as u8) << 1 | u8::from(number + 1 == parts.len());
        if truth.upload {
            frames.push((CLIENT, with_data(0x60 | toggle, &[]), "upload_segment_request"));
            frames.push((SERVER, with_data(command, part), "upload_segment_response"));
        } else {
            frames.push((CLIENT, with_data(command, part), "download_segment_request"));
            frames.push((SERVER, with_data(0x20 | toggle, &[]), "download_segment_response"));
        }
    }
    frames
}

fn block(truth: &Truth, input: &mut Input<'_>) -> Frames {
    let size = (truth.data.len() as u32).to_le_bytes();
    let options = input.byte();
    let blksize = input.one_of(&BLOCK_SIZES);
    let crc_flag = if options & 1 == 0 { 4 } else { 0 };
    let (sender, receiver) = if truth.upload { (SERVER, CLIENT) } else { (CLIENT, SERVER) };
    let mut frames = if truth.upload {
        vec![
            (CLIENT, initiate(0xA0 | crc_flag, truth.object, [blksize, 0, 0, 0]), "initiate_block_upload_request"),
            (SERVER, initiate(0xC2 | crc_flag, truth.object, size), "initiate_block_upload_response"),
            (CLIENT, with_data(0xA3, &[]), "start_block_upload"),
        ]
    } else {
        vec![
            (CLIENT, initiate(0xC2 | crc_flag, truth.object, size), "initiate_block_download_request"),
            (SERVER, initiate(0xA0 | crc_flag, truth.object, [blksize, 0, 0, 0]), "initiate_block_download_response"),
        ]
    };
    let parts: Vec<&[u8]> = truth.data.chunks(7).collect();
    let mut done = 0;
    while done < parts.len() {
        let sent = &parts[done..parts.len().min(done + usize::from(blksize))];
        for (number, part) in sent.iter().enumerate() {
            let last = done + number + 1 == parts.len();
            let command = number as u8 + 1 | if last { 0x80 } else { 0 };
            frames.push((sender, with_data(command, part), "block_segment"));
        }
        // Now and then a part is asked for again.
        let again = options & 6 == 6 && sent.len() > 1 && input.byte() & 3 == 0;
        let taken = if again { 1 + input.below(sent.len() - 1) } else { sent.len() };
        frames.push((receiver, with_data(0xA2, &[taken as u8, blksize]), "block_acknowledgement"));
        done += taken;
    }
    let unused = (truth.data.len().next_multiple_of(7) - truth.data.len()) as u8;
    let [low, high] = if crc_flag == 0 { [0; 2] } else { crc(&truth.data).to_le_bytes() };
    let words = match truth.upload {
        true => ("end_block_upload_request", "end_block_upload_response"),
        false => ("end_block_download_request", "end_block_download_response"),
    };
    frames.push((sender, with_data(0xC1 | unused << 2, &[low, high]), words.0));
    frames.push((receiver, with_data(0xA1, &[]), words.1));
    frames
}

fn data(input: &mut Input<'_>, size: usize) -> Vec<u8> {
    match input.byte() % 5 {
        0 => vec![0; size],
        1 => b"firmware 1.0\n".iter().copied().cycle().skip(input.below(13)).take(size).collect(),
        2 => {
            let mut bytes = Vec::new();
            while bytes.len() < size {
                let (index, sub) = input.one_of(&OBJECTS);
                let [low, high] = index.to_le_bytes();
                bytes.extend([input.one_of(&LIKE_COMMANDS), low, high, sub, input.byte(), 0, 0]);
            }
            bytes.truncate(size);
            bytes
        }
        3 => {
            // The bytes behind the command byte of a frame that names an object.
            let mut bytes = Vec::new();
            while bytes.len() < size {
                let (index, sub) = input.one_of(&OBJECTS);
                let [low, high] = index.to_le_bytes();
                bytes.extend([low, high, sub, input.byte(), 0, 0, 0]);
            }
            bytes.truncate(size);
            bytes
        }
        _ => {
            let mut mixed = 1 + input.word() as u32;
            let mut next = || {
                mixed = mixed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (mixed >> 24) as u8
            };
            let given = input.0.get(..size.min(40)).unwrap_or(&[]).to_vec();
            given.into_iter().chain(std::iter::repeat_with(&mut next)).take(size).collect()
        }
    }
}

/// One transfer: what it is, and its frames.
fn transfer(input: &mut Input<'_>) -> (Truth, Frames) {
    let kind = input.byte();
    let object = input.one_of(&OBJECTS);
    let typed = input.byte() & 1 == 0;
    let upload = kind & 1 == 0;
    let (mode, size) = match kind >> 1 & 3 {
        0 => ("expedited", 1 + input.below(4)),
        1 => ("segmented", 5 + input.below(70)),
        _ => ("block", 1 + input.below(if kind & 8 == 0 { 100 } else { LONGEST })),
    };
    let object = match size {
        1 if typed && upload => OF_ONE_BYTE,
        2 if typed && upload => OF_TWO_BYTES,
        _ => object,
    };
    let mut truth = Truth { upload, mode, object, data: data(input, size), abort: None };
    let mut frames = match mode {
        "expedited" => expedited(&truth),
        "segmented" => segmented(&truth),
        _ => block(&truth, input),
    };
    if kind >> 4 == 0 {
        // One side aborts: the server in its turn, the client before its next frame.
        let at = 1 + input.below(frames.len() - 1);
        let (by, code) = (frames[at].0, if frames[at].0 == CLIENT { 0x0800_0000_u32 } else { 0x0602_0000 });
        frames.truncate(at);
        frames.push((by, initiate(0x80, object, code.to_le_bytes()), "abort"));
        truth.abort = Some(code);
    }
    (truth, frames)
}

/// Transfers with two nodes, and their frames in the order of their times.
pub fn conversation(input: &mut Input<'_>) -> (Vec<Truth>, Vec<Sent>) {
    let (mut truths, mut sent) = (Vec::new(), Vec::new());
    let options = input.byte();
    let mut now = [20_000_000_i64, 20_300_000];
    let count = 1 + usize::from(input.byte()) % MOST_TRANSFERS;
    for number in 0..count {
        let node = if options & 1 == 0 { 0 } else { usize::from(input.byte() & 1) };
        let (truth, frames) = transfer(input);
        let pace = i64::from(input.one_of(&[3_u8, 8, 30])) * 100 * MICROSECOND_NS;
        for (client, data, command) in frames {
            // Which frame takes how long is no matter of the input: it is long enough.
            let varied = i64::from(data[1] ^ data[0].rotate_left(3)) * MICROSECOND_NS;
            now[node] += if client { pace / 2 + pace * varied / 512_000 } else { 150 * MICROSECOND_NS + varied };
            let id = NODES[node] + if client { 0x600 } else { 0x580 };
            sent.push(Sent { t_ns: now[node], id, data: data.to_vec(), transfer: Some(number), command });
        }
        now[node] += i64::from(input.one_of(&[2_u8, 20, 200])) * 1_000 * MICROSECOND_NS;
        truths.push(truth);
    }
    if options & 2 == 0 {
        let end = now[0].max(now[1]);
        for (place, node) in NODES.iter().enumerate().take(1 + usize::from(options & 1)) {
            let beats = (0..).map(|beat| 5_000_000 + place as i64 * 7_000_000 + beat * 100_000_000);
            sent.extend(beats.take_while(|t_ns| *t_ns < end).map(|t_ns| Sent {
                t_ns,
                id: 0x700 + node,
                data: vec![5],
                transfer: None,
                command: "",
            }));
        }
    }
    sent.sort_by_key(|frame| frame.t_ns);
    (truths, sent)
}
