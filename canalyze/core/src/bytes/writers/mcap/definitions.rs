//! Message definitions in the form of ROS. Readers decode by the definitions in the file, so each includes every type
//! that its message contains.
//!
//! The first three are types of other packages, field by field; the order of fields is the order on the wire and must
//! not change. The rest (`canalyze_msgs`) are ours.

/// A definition and its name.
#[derive(Clone, Copy, Debug)]
pub(super) struct Definition {
    /// `package/msg/Name`.
    pub(super) name: &'static str,
    /// Its fields, without the contained types.
    pub(super) fields: &'static str,
}

impl Definition {
    /// Returns the complete text.
    pub(super) fn text(self) -> String {
        whole(self.fields)
    }
}

/// The contained types of a message with a header.
const CONTAINED: &str = "\
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
";

/// Returns the complete text of a message with these fields, the first of which is a header or a time.
pub(super) fn whole(fields: &str) -> String {
    [fields, CONTAINED].concat()
}

/// Classic frames as published by `ros2_socketcan`.
pub(super) const FRAME: Definition = Definition {
    name: "can_msgs/msg/Frame",
    fields: "\
std_msgs/Header header
uint32 id
bool is_rtr
bool is_extended
bool is_error
uint8 dlc
uint8[8] data
",
};

/// CAN FD frames as published by `ros2_socketcan`.
pub(super) const FD_FRAME: Definition = Definition {
    name: "ros2_socketcan_msgs/msg/FdFrame",
    fields: "\
std_msgs/Header header
uint32 id
bool is_extended
bool is_error
uint8 len
uint8[<=64] data
",
};

/// CAN FD frames with all their flags.
pub(super) const DATASPEED_FRAME: Definition = Definition {
    name: "dataspeed_can_msgs/msg/Frame",
    fields: "\
std_msgs/Header header
uint32 id
bool extended
bool fdf
bool brs
bool esi
bool rtr
uint8[<=64] data
",
};

/// A line of a log, which log panels show.
pub(super) const LOG: Definition = Definition {
    name: "rcl_interfaces/msg/Log",
    fields: "\
byte DEBUG=10
byte INFO=20
byte WARN=30
byte ERROR=40
byte FATAL=50
builtin_interfaces/Time stamp
uint8 level
string name
string msg
string file
string function
uint32 line
",
};

/// The NMT state of a node.
pub(super) const NMT_STATE: Definition = Definition {
    name: "canalyze_msgs/msg/NmtState",
    fields: "\
# As boot-up, heartbeat and guarding show it: 0 booted (pre-operational), 4 stopped, 5 operational, 127 pre-operational.
std_msgs/Header header
uint8 state
string name
",
};

/// The state of a drive.
pub(super) const DRIVE_STATE: Definition = Definition {
    name: "canalyze_msgs/msg/DriveState",
    fields: "\
# The state of a CiA 402 power drive system, whenever a statusword in a PDO shows another one.
std_msgs/Header header
uint16 statusword
string state
",
};

/// An emergency.
pub(super) const EMERGENCY: Definition = Definition {
    name: "canalyze_msgs/msg/Emergency",
    fields: "\
std_msgs/Header header
uint16 code
uint8 error_register
uint8[5] manufacturer
string text
",
};

/// An SDO transfer.
pub(super) const SDO_TRANSFER: Definition = Definition {
    name: "canalyze_msgs/msg/SdoTransfer",
    fields: "\
# An SDO transfer at its end. Without its initiate request in the capture index, sub and name are empty.
std_msgs/Header header
# Of its first frame; 0 without stamps.
builtin_interfaces/Time start
# In seconds; NaN without stamps.
float64 duration
# upload, download
string direction
# expedited, segmented, block
string mode
uint16 index
uint8 sub
string name
# The value in words.
string value
# Bytes transferred, and the first 1024 of them.
uint64 size
uint8[] data
# ok, aborted, incomplete, failed
string status
uint32 abort_code
string abort_text
# Numbers in the capture, from 1.
uint64 first_frame
uint64 last_frame
# All of it in words, on one line.
string text
",
};

/// A finding.
pub(super) const FINDING: Definition = Definition {
    name: "canalyze_msgs/msg/Finding",
    fields: "\
std_msgs/Header header
string code
string name
# info, warning, error
string severity
string message
# 0 where none is concerned.
uint8 node
# The object; 0 where none is concerned.
uint16 index
uint8 sub
# Numbers in the capture, from 1; 0 where there is none: the frame that shows it, and an earlier one that belongs to it.
uint64 frame
uint64 cause_frame
# The one of the two that the message is about, and the frame of what explains it: then it is a consequence.
uint64 about_frame
uint64 because_of
",
};
