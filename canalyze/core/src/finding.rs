//! Findings and the table of rules that raise them.
//!
//! A rule has a code, a name, a default severity and the clause it rests on; its words stand in `text`. A rule
//! is added here and in `text/{zh,en}/findings/`, and gets a sample that raises it.

use std::sync::Arc;

use crate::frame::{BusId, CanId, FrameRef};
use crate::services::sdo::wire::{Mux, Side};

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Worth knowing; normal traffic may show it.
    Info,
    /// Suspicious: an engineer should look.
    Warning,
    /// The standard is violated.
    Error,
}

impl Severity {
    /// The word in machine output.
    pub fn name(self) -> &'static str {
        match self {
            Self::Info => "info",
            Self::Warning => "warning",
            Self::Error => "error",
        }
    }
}

/// One row of the catalogue.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    /// The rule.
    pub code: Code,
    /// Its code as printed.
    pub id: &'static str,
    /// Its name in kebab-case.
    pub name: &'static str,
    /// Default severity.
    pub severity: Severity,
    /// The clause of the standard, or what else it rests on.
    pub clause: &'static str,
}

macro_rules! rules {
    ($($(#[$doc:meta])* $code:ident $id:literal $name:literal $severity:ident $clause:literal;)*) => {
        /// The rules, by their code.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Code {
            $($(#[$doc])* $code,)*
        }

        /// The catalogue, in order of the code.
        pub static RULES: &[Rule] = &[
            $(Rule { code: Code::$code, id: $id, name: $name, severity: Severity::$severity, clause: $clause },)*
        ];

        impl Code {
            /// The rule's row.
            pub fn rule(self) -> &'static Rule {
                match self {
                    $(Self::$code => {
                        static RULE: Rule = Rule {
                            code: Code::$code, id: $id, name: $name, severity: Severity::$severity, clause: $clause,
                        };
                        &RULE
                    })*
                }
            }
        }
    };
}

rules! {
    /// The recording controller is off the bus.
    Bus001 "BUS001" "bus-off" Error "ISO 11898-1";
    /// The recording controller is error passive.
    Bus002 "BUS002" "error-passive" Warning "ISO 11898-1";
    /// An error counter of the recording controller is at its warning level.
    Bus003 "BUS003" "error-warning-level" Info "ISO 11898-1";
    /// A frame was acknowledged by nobody, or could not be transmitted in time.
    Bus004 "BUS004" "not-transmitted" Warning "ISO 11898-1";
    /// A buffer of the recording controller overflowed.
    Bus005 "BUS005" "controller-overflow" Warning "-";
    /// The recording controller is error active again, or was restarted.
    Bus006 "BUS006" "controller-recovered" Info "ISO 11898-1";
    /// A frame violated the CAN protocol.
    Bus007 "BUS007" "bus-error" Warning "ISO 11898-1";
    /// The transceiver reports a faulty wire.
    Bus008 "BUS008" "transceiver-fault" Warning "ISO 11898-3";
    /// Lines that should hold a frame and cannot be read.
    Cap001 "CAP001" "unreadable-lines" Warning "-";
    /// The capturing program says that it lost frames.
    Cap002 "CAP002" "dropped-frames" Warning "-";
    /// Stamps of a pipe go backwards.
    Cap003 "CAP003" "stamps-backward" Warning "-";
    /// A part of the file is damaged and was passed over.
    Cap004 "CAP004" "damaged-capture" Warning "-";
    /// The file ends in the middle of a record.
    Cap005 "CAP005" "capture-cut" Info "-";
    /// A stamp is earlier than the one before: the clock was set.
    Cap006 "CAP006" "clock-set-back" Warning "-";
    /// A state that no command led to.
    Drv001 "DRV001" "illegal-transition" Warning "CiA 402-2, power drive system";
    /// A command that the drive has not followed.
    Drv002 "DRV002" "command-without-effect" Warning "CiA 402-2, power drive system";
    /// A fault that no EMCY has announced.
    Drv003 "DRV003" "fault-without-emcy" Info "CiA 402-2, EMCY";
    /// Another mode of operation is displayed than the one asked for.
    Drv004 "DRV004" "mode-not-taken" Info "CiA 402-2, 6060h, 6061h";
    /// A drive has entered a fault state.
    Drv005 "DRV005" "drive-fault" Error "CiA 402-2, power drive system";
    /// A value read before any write differs from the EDS's default.
    Eds001 "EDS001" "differs-from-eds" Info "CiA 306";
    /// A value read before any write differs from what a DCF configures.
    Eds002 "EDS002" "differs-from-dcf" Warning "CiA 306";
    /// An object was accessed that the description lacks.
    Eds003 "EDS003" "not-in-description" Info "CiA 306";
    /// Device type, vendor-ID or product code are not the description's.
    Eds004 "EDS004" "identity-differs" Warning "CiA 306";
    /// An emergency error code with error register 0.
    Emc001 "EMC001" "code-without-register" Warning "CiA 301 7.2.7.3.1";
    /// Error reset while other errors remain.
    Emc002 "EMC002" "partial-reset" Info "CiA 301 7.2.7.1";
    /// Bit 6 of the error register is set.
    Emc003 "EMC003" "reserved-register-bit" Warning "CiA 301 7.5.2.2";
    /// An emergency in Stopped or before the boot-up.
    Emc004 "EMC004" "emcy-in-wrong-state" Warning "CiA 301 7.3.2.2";
    /// Two emergencies closer than the inhibit time.
    Emc005 "EMC005" "emcy-inhibit-time" Warning "CiA 301 7.5.2.18";
    /// An emergency has another length than 8 bytes.
    Emc006 "EMC006" "emcy-length" Warning "CiA 301 7.2.7.3";
    /// A device reports an error of its own: current, voltage, temperature, hardware, software, a module.
    Emc007 "EMC007" "device-error" Error "CiA 301 7.2.7.1";
    /// A device reports an error of communication, or one that is not specific.
    Emc008 "EMC008" "reported-error" Warning "CiA 301 7.2.7.1";
    /// An error that was not taken back, or was sent several times.
    Emc009 "EMC009" "error-standing" Info "CiA 301 7.2.7.1";
    /// Many emergencies in a short time.
    Emc010 "EMC010" "emcy-flood" Warning "CiA 301 7.2.7.1";
    /// An SDO transfer that is expected has not come, or not in time.
    Exp001 "EXP001" "transfer-missing" Error "-";
    /// An SDO transfer of a sequence came before the one that is expected before it.
    Exp002 "EXP002" "transfer-out-of-order" Error "-";
    /// An SDO transfer carried another value, or ended otherwise, than expected.
    Exp003 "EXP003" "transfer-differs" Error "-";
    /// An SDO transfer that must not occur.
    Exp004 "EXP004" "forbidden-transfer" Error "-";
    /// A node or a drive has not shown an expected state, or not in time.
    Exp005 "EXP005" "state-not-reached" Error "-";
    /// A node or a drive has left a state that it should keep.
    Exp006 "EXP006" "state-left" Error "-";
    /// The value of a signal is beyond its expected limits.
    Exp007 "EXP007" "signal-out-of-range" Error "-";
    /// The PDOs of a signal do not come at the expected rate.
    Exp008 "EXP008" "signal-rate" Error "-";
    /// Heartbeats do not come with the expected period.
    Exp009 "EXP009" "heartbeat-period" Error "-";
    /// SYNCs do not come with the expected period.
    Exp010 "EXP010" "sync-period" Error "-";
    /// An emergency that is expected has not come.
    Exp011 "EXP011" "emcy-missing" Error "-";
    /// An emergency that must not occur.
    Exp012 "EXP012" "emcy-unexpected" Error "-";
    /// Something took longer than expected.
    Exp013 "EXP013" "latency" Error "-";
    /// The bus is busier than expected.
    Exp014 "EXP014" "bus-load" Error "-";
    /// The capture cannot show whether an expectation holds.
    Exp015 "EXP015" "expectation-not-checked" Info "-";
    /// A signal that is expected has not come.
    Exp016 "EXP016" "signal-missing" Error "-";
    /// The toggle bit of guarding answers does not alternate.
    Grd001 "GRD001" "guarding-toggle" Error "CiA 301 7.2.8.3.2.1";
    /// A guarding request was not answered.
    Grd002 "GRD002" "guarding-unanswered" Warning "CiA 301 7.2.8.3.2.1";
    /// One node is guarded and sends heartbeats.
    Grd003 "GRD003" "heartbeat-and-guarding" Warning "CiA 301 7.2.8.3.2";
    /// A node that is guarded was never seen.
    Grd004 "GRD004" "guarded-node-absent" Info "-";
    /// A heartbeat came late.
    Hbt001 "HBT001" "heartbeat-late" Warning "CiA 301 7.2.8.3.2.2";
    /// No heartbeat for longer than a consumer waits, or than three periods.
    Hbt002 "HBT002" "heartbeat-lost" Error "CiA 301 7.2.8.3.2.2";
    /// Error control with a state that the standard does not define.
    Hbt003 "HBT003" "unknown-state" Warning "CiA 301 7.2.8.3.2";
    /// Two nodes use one node-ID.
    Hbt004 "HBT004" "duplicate-node-id" Warning "CiA 301 7.3.5";
    /// The whole bus was silent: no heartbeat could be seen.
    Hbt005 "HBT005" "silent-bus" Info "-";
    /// Error control has another length than 1 byte.
    Hbt006 "HBT006" "error-control-length" Warning "CiA 301 7.2.8.3.2";
    /// A command specifier that CiA 305 does not define for this side, or a frame of another length than 8 bytes.
    Lss001 "LSS001" "unknown-command" Warning "CiA 305";
    /// A slave's frame that no request explains.
    Lss002 "LSS002" "answer-without-request" Warning "CiA 305";
    /// A configuration command while no slave is in the configuration state.
    Lss003 "LSS003" "configuration-without-selection" Warning "CiA 305";
    /// A slave refuses a node-ID, a bit timing, or to store them.
    Lss004 "LSS004" "error-code" Warning "CiA 305";
    /// A node-ID was given and should be in effect, and no node has booted up with it.
    Lss005 "LSS005" "no-boot-up-after-node-id" Info "CiA 305";
    /// A bit timing was configured and neither activated nor stored.
    Lss006 "LSS006" "bit-timing-not-activated" Info "CiA 305";
    /// More than one slave answers what only one should.
    Lss007 "LSS007" "several-answers" Warning "CiA 305";
    /// A frame while the bus should be silent for the change of the bit rate.
    Lss008 "LSS008" "frame-during-switch-delay" Warning "CiA 305";
    /// The selected slave does not answer.
    Lss009 "LSS009" "request-unanswered" Warning "CiA 305";
    /// A Fastscan step that no slave answers.
    Lss010 "LSS010" "invalid-fastscan" Info "CiA 305";
    /// The parts of a selective switch are not in their order.
    Lss011 "LSS011" "selective-order" Warning "CiA 305";
    /// No slave answers.
    Lss012 "LSS012" "no-slave-answers" Info "CiA 305";
    /// The traffic on these identifiers does not look like LSS.
    Lss030 "LSS030" "not-lss" Info "-";
    /// A multiplex PDO has another length than 8 bytes.
    Mpd001 "MPD001" "mpdo-length" Warning "CiA 301 7.2.2.4";
    /// NMT node control: unknown command, invalid node-ID or wrong length.
    Nmt001 "NMT001" "invalid-node-control" Warning "CiA 301 7.2.8.3.1";
    /// A node does not do what it was commanded.
    Nmt002 "NMT002" "command-without-effect" Warning "CiA 301 7.2.8.3.1";
    /// A boot-up that no reset command explains.
    Nmt003 "NMT003" "spontaneous-reset" Warning "CiA 301 7.3.2.1";
    /// A change of state that no command explains.
    Nmt004 "NMT004" "state-change-without-command" Warning "CiA 301 7.3.2.1";
    /// A change of state that an error explains (1029h).
    Nmt005 "NMT005" "state-change-on-error" Info "CiA 301 7.5.2.32";
    /// A PDO is shorter than its mapping.
    Pdo001 "PDO001" "pdo-too-short" Error "CiA 301 7.5.2.36, 7.5.2.38";
    /// A TPDO of a node that is not Operational.
    Pdo002 "PDO002" "tpdo-when-not-operational" Error "CiA 301 7.3.2.2";
    /// An RPDO to a node that is not Operational.
    Pdo003 "PDO003" "rpdo-to-not-operational" Info "CiA 301 7.3.2.2";
    /// An event-driven TPDO within its inhibit time.
    Pdo004 "PDO004" "inhibit-time" Warning "CiA 301 7.5.2.37";
    /// An event-driven TPDO does not come though its event timer has run out.
    Pdo005 "PDO005" "event-timer-late" Warning "CiA 301 7.5.2.37";
    /// A PDO is longer than its mapping.
    Pdo006 "PDO006" "pdo-too-long" Warning "CiA 301 7.5.2.36, 7.5.2.38";
    /// A reserved transmission type was written and acknowledged.
    Pdo008 "PDO008" "reserved-transmission-type" Warning "CiA 301 7.5.2.35, 7.5.2.37";
    /// The mapping of a valid PDO was changed.
    Pdo009 "PDO009" "mapping-changed-while-valid" Warning "CiA 301 7.5.2.36, 7.5.2.38";
    /// The identifier of a valid PDO was changed.
    Pdo010 "PDO010" "cob-id-changed-while-valid" Warning "CiA 301 7.5.2.35, 7.5.2.37";
    /// A remote frame for a TPDO that allows none.
    Pdo011 "PDO011" "rtr-not-allowed" Warning "CiA 301 7.5.2.37";
    /// A PDO is not as long as the EDS's default mapping.
    Pdo012 "PDO012" "pdo-length-differs-from-eds" Warning "CiA 301 7.5.2.36, 7.5.2.38";
    /// An RPDO does not come within its deadline.
    Pdo013 "PDO013" "rpdo-deadline" Info "CiA 301 7.5.2.35";
    /// A restricted CAN-ID was configured.
    Pdo014 "PDO014" "restricted-cob-id" Warning "CiA 301 7.3.5";
    /// A PDO without mapped objects is sent.
    Pdo015 "PDO015" "mapping-empty" Info "CiA 301 7.5.2.36, 7.5.2.38";
    /// A mapping of more bits than a frame holds was acknowledged.
    Pdo016 "PDO016" "mapping-too-long" Error "CiA 301 7.5.2.36, 7.5.2.38";
    /// A TPDO is sent though it was made invalid.
    Pdo018 "PDO018" "disabled-pdo-sent" Warning "CiA 301 7.5.2.37";
    /// A PDO is on the bus that its receiver or its description has disabled.
    Pdo019 "PDO019" "disabled-pdo-on-bus" Info "CiA 301 7.5.2.35, 7.5.2.37";
    /// Toggle bit not alternated, or not repeated in the answer.
    Sdo001 "SDO001" "toggle-bit" Error "CiA 301 7.2.4.3.5, 7.2.4.3.6";
    /// A request without response, or a response without request.
    Sdo002 "SDO002" "unpaired" Warning "CiA 301 7.2.4.1";
    /// The response names another object than the request.
    Sdo003 "SDO003" "multiplexor-mismatch" Error "CiA 301 7.2.4.3.3";
    /// n is not 0 though e and s are not both 1.
    Sdo004 "SDO004" "invalid-unused-count" Warning "CiA 301 7.2.4.3.3";
    /// A segment that is not the last one is not full.
    Sdo005 "SDO005" "short-segment" Info "CiA 301 7.2.4.3.5";
    /// The bytes transferred are not as many as indicated.
    Sdo006 "SDO006" "size-mismatch" Error "CiA 301 7.2.4.3.3";
    /// A segment outside a transfer or after its last one, or a transfer without a last segment.
    Sdo007 "SDO007" "segment-outside-transfer" Error "CiA 301 7.2.4.3.5";
    /// A new initiate request while a transfer is open.
    Sdo008 "SDO008" "restarted-transfer" Warning "CiA 301 7.2.4.1";
    /// Reserved bits or bytes, or bytes without data, are not 0.
    Sdo009 "SDO009" "reserved-not-zero" Info "CiA 301 7.2.4.3";
    /// An SDO frame has another length than 8 bytes.
    Sdo010 "SDO010" "frame-length" Warning "CiA 301 7.2.4.3";
    /// SDO with a node that is Stopped or has not booted.
    Sdo011 "SDO011" "sdo-in-wrong-state" Error "CiA 301 7.3.2.2";
    /// Block transfer: sequence number, acknowledgement, block size or end out of order.
    Sdo012 "SDO012" "block-sequence" Error "CiA 301 7.2.4.3.9 to 7.2.4.3.15";
    /// The length of a value is not that of the object's type in the description.
    Sdo013 "SDO013" "value-length" Warning "CiA 301 7.4.7, CiA 306";
    /// An access succeeded that the description rules out.
    Sdo014 "SDO014" "access" Warning "CiA 301 7.4.3, CiA 306";
    /// The same request twice without a response in between.
    Sdo015 "SDO015" "repeated-request" Info "CiA 301 7.2.4.1";
    /// A transfer was aborted.
    Sdo017 "SDO017" "abort" Info "CiA 301 7.2.4.3.17";
    /// Block transfer: the CRC does not match the data.
    Sdo019 "SDO019" "block-crc" Error "CiA 301 7.2.4.3.16";
    /// An answer to a request that was given up.
    Sdo020 "SDO020" "late-answer" Info "CiA 301 7.2.4.1";
    /// Initiate download with e = s = 0 whose data are meant as expedited (Roboteq's manual).
    Sdo021 "SDO021" "unmarked-expedited-download" Warning "CiA 301 7.2.4.3.3";
    /// Initiate upload response with e = s = 0 whose data are meant as expedited (Roboteq's manual).
    Sdo022 "SDO022" "unmarked-expedited-upload" Warning "CiA 301 7.2.4.3.3";
    /// A command specifier that the standard does not define for this side.
    Sdo023 "SDO023" "unknown-command" Error "CiA 301 7.2.4.3";
    /// The traffic on these identifiers does not look like SDO.
    Sdo030 "SDO030" "not-sdo" Info "-";
    /// Requests of which none was answered in the capture.
    Sdo031 "SDO031" "no-server" Info "-";
    /// The two frames of an SRDO are not each other's inverse.
    Srd001 "SRD001" "not-inverse" Error "CiA 304, EN 50325-5";
    /// The inverted frame of an SRDO comes later than the validation time allows.
    Srd002 "SRD002" "validation-time" Error "CiA 304, 1301h:03";
    /// Two SRDOs are further apart than the safeguard cycle time allows.
    Srd003 "SRD003" "cycle-time" Error "CiA 304, 1301h:02";
    /// The inverted frame comes first, or one of the two frames is not there.
    Srd004 "SRD004" "pair-order" Warning "CiA 304, EN 50325-5";
    /// SRDOs of a node that is not Operational.
    Srd005 "SRD005" "not-operational" Warning "CiA 304, CiA 301 7.3.2.2";
    /// A SYNC has another length than 1019h asks for, or than the SYNCs before.
    Syn001 "SYN001" "sync-length" Error "CiA 301 7.2.5.3.1, 7.5.2.22";
    /// The synchronous counter does not go on as it should.
    Syn002 "SYN002" "sync-counter" Error "CiA 301 7.2.5.3.1, 7.5.2.22";
    /// A SYNC is missing, late or one too many, or the period is not the configured one.
    Syn003 "SYN003" "sync-period" Warning "CiA 301 7.2.5, 7.5.2.6";
    /// A synchronous TPDO came after the synchronous window.
    Syn004 "SYN004" "outside-window" Warning "CiA 301 7.2.5, 7.5.2.7";
    /// Synchronous TPDOs without any SYNC before.
    Syn005 "SYN005" "before-first-sync" Info "CiA 301 7.2.2.2";
    /// Two nodes produce SYNC.
    Syn006 "SYN006" "two-producers" Error "CiA 301 7.2.5";
    /// The synchronous window is not shorter than the communication cycle.
    Syn007 "SYN007" "window-not-below-period" Warning "CiA 301 7.5.2.6, 7.5.2.7";
    /// A cyclic synchronous TPDO did not come in its cycle.
    Syn008 "SYN008" "missing-synchronous-pdo" Warning "CiA 301 7.2.2.2, 7.5.2.37";
    /// A synchronous TPDO came more than once in a cycle.
    Syn009 "SYN009" "twice-in-cycle" Warning "CiA 301 7.2.2.2, 7.5.2.37";
    /// A cyclic synchronous TPDO came in another cycle than it should.
    Syn010 "SYN010" "wrong-cycle" Warning "CiA 301 7.2.2.2, 7.5.2.37";
    /// Times of SYNC cannot be judged.
    Syn011 "SYN011" "sync-not-judged" Info "-";
    /// A SYNC was late, and those after it came in time.
    Syn012 "SYN012" "late-sync" Info "CiA 301 7.2.5, 7.5.2.6";
    /// SYNC has stopped, and nodes are Operational all the same.
    Syn013 "SYN013" "sync-stopped" Info "CiA 301 7.2.5, 7.5.2.6";
    /// A time of day that cannot be, or reserved bits that are set.
    Tim001 "TIM001" "invalid-time" Warning "CiA 301 7.2.6";
    /// TIME jumps against the clock of the capture.
    Tim002 "TIM002" "time-jump" Warning "CiA 301 7.2.6";
}

impl Code {
    /// The rule with this code as printed, whatever its case.
    pub fn parse(id: &str) -> Option<Self> {
        RULES.iter().find(|rule| rule.id.eq_ignore_ascii_case(id)).map(|rule| rule.code)
    }
}

/// What a finding measured.
#[derive(Clone, Debug, PartialEq)]
pub enum Facts {
    /// Nothing beyond the code.
    None,
    /// Lines that could not be read.
    Lines {
        /// How many.
        count: u64,
    },
    /// Frames lost, as the capture says.
    Dropped {
        /// Since the last such line.
        count: u64,
        /// In total.
        total: u64,
    },
    /// Toggle bit.
    Toggle {
        /// What was due.
        expected: bool,
        /// What came.
        found: bool,
        /// Who sent it.
        by: Side,
    },
    /// The half of an exchange that is not there.
    Missing {
        /// Who should have sent it.
        by: Side,
    },
    /// A sub-block of which no acknowledgement was captured.
    NotAcknowledged,
    /// The same response was seen before: a duplicate.
    Duplicate,
    /// Two objects.
    Objects {
        /// What was asked for.
        expected: Mux,
        /// What was answered.
        found: Mux,
    },
    /// n of an initiate or a segment.
    Unused(u8),
    /// Bytes.
    Size {
        /// What was indicated.
        indicated: u64,
        /// What was transferred.
        transferred: u64,
    },
    /// A segment after the last one, or outside any transfer.
    Outside,
    /// All bytes were transferred but no segment was marked as the last one.
    NoLast,
    /// A frame's length in bytes.
    Length(u8),
    /// Sequence numbers of block segments.
    Sequence {
        /// The number that was due.
        expected: u8,
        /// The number that came.
        found: u8,
    },
    /// An acknowledgement of more segments than were sent.
    Acknowledged {
        /// ackseq.
        ackseq: u8,
        /// The last segment sent.
        sent: u8,
    },
    /// Segments after the acknowledged ones were not sent again.
    NotResent {
        /// ackseq.
        ackseq: u8,
    },
    /// A block size out of 1..=127.
    BlockSize(u8),
    /// The end of a block transfer came before its last segment was acknowledged.
    EarlyEnd,
    /// The end of a block transfer was not confirmed.
    EndNotConfirmed,
    /// CRC of a block transfer.
    Crc {
        /// Over the data as transferred.
        computed: u16,
        /// In the frame.
        found: u16,
        /// What it would match.
        matches: CrcMatch,
    },
    /// An abort.
    Abort {
        /// Abort code.
        code: u32,
        /// Who sent it.
        by: Side,
    },
    /// A command byte.
    Command(u8),
    /// Frames on a channel.
    Frames {
        /// How many.
        count: u64,
    },
    /// One of the rule's sentences (`text::{zh,en}::findings`), filled with what was measured.
    Told {
        /// Which of the rule's sentences, from 0.
        face: u8,
        /// What was measured, by the names that stand in the sentence and in JSON. Unused places are [`NOTHING`].
        measured: [(&'static str, Quantity); MEASURED],
    },
    /// An expectation does not hold, or cannot be checked. Rare, and large: apart, so that findings stay small.
    Unmet(Arc<Unmet>),
    /// The finding stands for this many more of its kind on the same object.
    Repeated {
        /// How many were not shown.
        count: u64,
    },
}

/// Most quantities of one finding.
pub const MEASURED: usize = 4;

/// An unused place of [`Facts::Told`].
pub const NOTHING: (&str, Quantity) = ("", Quantity::Nothing);

impl Facts {
    /// A sentence of the rule with up to [`MEASURED`] quantities; further ones are cut off.
    pub fn told(face: u8, quantities: &[(&'static str, Quantity)]) -> Self {
        let mut measured = [NOTHING; MEASURED];
        for (slot, quantity) in measured.iter_mut().zip(quantities) {
            *slot = *quantity;
        }
        Self::Told { face, measured }
    }

    /// What a finding says that stands for so many more like this one.
    pub fn repeated(&self, count: u64) -> Self {
        match self {
            Self::Unmet(unmet) => {
                Self::Unmet(Arc::new(Unmet { said: Vec::new(), repeated: count, ..Unmet::clone(unmet) }))
            }
            _ => Self::Repeated { count },
        }
    }
}

/// An expectation that does not hold, or cannot be checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Unmet {
    /// Its file and line, `boot.expect.toml:12`; to be escaped.
    pub expectation: Arc<str>,
    /// Which of the rule's sentences, from 0.
    pub face: u8,
    /// What was expected and found, by the names that stand in the sentence and in JSON.
    pub said: Vec<(&'static str, Said)>,
    /// The finding stands for this many more of its kind; 0: for itself.
    pub repeated: u64,
}

/// Something expected or found.
#[derive(Clone, Debug, PartialEq)]
pub enum Said {
    /// As other rules measure it.
    Quantity(Quantity),
    /// A number with a fraction.
    Real(f64),
    /// A truth value.
    Bool(bool),
    /// Text of the capture or of an expectation; to be escaped.
    Text(Arc<str>),
    /// Bytes.
    Bytes(Arc<[u8]>),
    /// A word of the rule's sentence, the same in JSON: it is not shown to people.
    Word(&'static str),
}

/// Something measured or expected. Its kind says how it is printed and what it is in JSON.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Quantity {
    /// Unused.
    Nothing,
    /// A number.
    Count(u64),
    /// A number with sign.
    Signed(i64),
    /// A time or a difference of times in ns; words choose a unit, JSON has ns.
    Ns(i64),
    /// Two hexadecimal digits.
    Hex2(u8),
    /// Four hexadecimal digits.
    Hex4(u16),
    /// Eight hexadecimal digits.
    Hex8(u32),
    /// An object: `1800h:01`.
    Object(Mux),
    /// A CAN identifier.
    Id(CanId),
    /// An NMT state as error control carries it: 00, 04, 05, 7F.
    State(u8),
    /// An NMT command specifier: 01, 02, 80, 81, 82.
    Command(u8),
    /// A PDO: whether it is a TPDO, and its number.
    Pdo(bool, u16),
    /// A CiA 402 statusword: words name its state.
    Statusword(u16),
    /// A CiA 402 controlword: words name its command.
    Controlword(u16),
    /// A CiA 402 mode of operation.
    Mode(i8),
    /// An LSS command specifier: words name it.
    Lss(u8),
    /// An error code of an LSS slave, with the command specifier that it answers: words name it.
    LssError(u8, u8),
    /// An emergency error code.
    Emcy(u16),
    /// A data type code (CiA 301, 7.4.7).
    Type(u16),
    /// A state of CiA 402's power drive system, as a statusword that says it: words name it.
    Drive(u16),
    /// An SDO abort code: words name it.
    Abort(u32),
}

/// What a wrong CRC would be right for: it tells an engineer where the fault is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CrcMatch {
    /// Nothing known.
    Nothing,
    /// The data with the padding of the last segment.
    WithPadding,
    /// The right polynomial with initial value FFFFh (CCITT-FALSE).
    InitialFfff,
    /// The reflected variant (KERMIT).
    Reflected,
}

/// Something an engineer should know, at a frame.
#[derive(Clone, Debug)]
pub struct Finding {
    /// The rule.
    pub code: Code,
    /// The frame that shows it. What is only known later stands at the frame that proves it.
    pub at: FrameRef,
    /// The earlier frame it is about, if another.
    pub cause: Option<FrameRef>,
    /// The bus.
    pub bus: BusId,
    /// The node, where one is concerned.
    pub node: Option<u8>,
    /// The object, where one is concerned.
    pub object: Option<Mux>,
    /// What was measured.
    pub facts: Facts,
    /// The frame of the event, or of the finding, that explains it: it is a consequence of that, and no fault by itself.
    pub because_of: Option<FrameRef>,
}

impl Finding {
    /// How bad it is: as its rule says, but a consequence is only worth knowing.
    pub fn severity(&self) -> Severity {
        if self.because_of.is_some() { Severity::Info } else { self.code.rule().severity }
    }

    /// The expectation that it is about, `boot.expect.toml:12`, where it is about one.
    pub fn expectation(&self) -> Option<&Arc<str>> {
        if let Facts::Unmet(unmet) = &self.facts { Some(&unmet.expectation) } else { None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_consequence_is_only_worth_knowing() {
        let (at, facts) = (FrameRef::default(), Facts::None);
        let raised = Finding {
            code: Code::Hbt002,
            at,
            cause: None,
            bus: BusId(0),
            node: Some(5),
            object: None,
            facts,
            because_of: None,
        };
        assert_eq!(raised.severity(), Severity::Error);
        assert_eq!(Finding { because_of: Some(at), ..raised }.severity(), Severity::Info);
    }
}
