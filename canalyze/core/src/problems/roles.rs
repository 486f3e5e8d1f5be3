//! The roles of kinds: what a kind is for the rules of cause, the status, the comparison and the trackers of others.

/// A role. Kinds have several; the column `roles` of the table of kinds lists them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KindRole {
    /// Its node cannot be heard, or has booted.
    Gone,
    /// Its nodes are silent.
    Silent,
    /// Several nodes are silent together.
    Segment,
    /// One node is silent.
    AloneSilent,
    /// A node has restarted by itself.
    Restart,
    /// A node restarts again and again.
    Loop,
    /// A boot-up shows it.
    Booted,
    /// A supply that dips may cause it.
    Falls,
    /// Nodes are silent or restart.
    Outage,
    /// Its node may have lost its configuration.
    LosesConfiguration,
    /// Its node was never heard.
    NeverHeard,
    /// Its node does not respond to guarding.
    Guarding,
    /// The master stops guarding.
    NoGuarding,
    /// Its node sends no heartbeats.
    NoHeartbeats,
    /// Heartbeats come more slowly.
    Slower,
    /// A loss of communication.
    CommunicationLost,
    /// It shows after an outage.
    ShowsOutage,
    /// Its node left Operational by itself.
    LeftState,
    /// Its node is not Operational.
    NotOperational,
    /// Its node is not started.
    NeverStarted,
    /// Its node waits to be started.
    AwaitsStart,
    /// Its node does not follow an NMT command.
    IgnoresCommand,
    /// The recording loses single frames.
    LosesFrames,
    /// An NMT command explains it.
    Commanded,
    /// A reset command explains it.
    Reset,
    /// Heartbeats of one node are missing.
    LostBeats,
    /// A consumer misses heartbeats.
    ConsumerReports,
    /// A node was requested in vain.
    Asked,
    /// It follows where a node is not started.
    Expected,
    /// Repeated, it is a restart loop.
    MayLoop,
    /// A node left its state without a command.
    StateUnasked,
    /// An RPDO is not sent any more.
    NoRpdo,
    /// It may be the sign of a second device.
    ShowsSecond,
    /// It tells that a drive is in fault.
    FaultSeen,
    /// An emergency near it belongs to it.
    Announced,
    /// A command stopped it.
    Stop,
    /// Two masters contradict each other.
    Contradicts,
    /// Two devices have one node-ID.
    SecondDevice,
    /// A heartbeat consumer reported it.
    Reported,
    /// The consumer time is too short.
    TimeTooShort,
    /// No frame shows that it has ended.
    Lasting,
    /// It may recur by itself.
    Recurs,
    /// Silence is what shows it.
    Unheard,
    /// A busy node or a full bus may cause it.
    Late,
    /// A node that stores something may cause it.
    Busy,
    /// Errors on the bus may cause it.
    Disturbed,
    /// It rests on times.
    Timed,
    /// A node stores parameters or a program.
    Storing,
    /// One identifier floods the bus.
    Floods,
    /// The bus is full.
    Overloads,
    /// A fault of the bus.
    BusFault,
    /// It shows as error frames, or is one of their causes.
    Noise,
    /// The controller is off.
    BusOff,
    /// The controller is error passive.
    Passive,
    /// Error frames.
    ErrorFrames,
    /// A node reports errors of the bus.
    ReportsBus,
    /// A gap in the recording.
    Gap,
    /// It is harmless, although it has an effect.
    Explained,
    /// A service of an SDO server fails.
    Service,
    /// Those of one SDO server are one problem.
    Sdo,
    /// Requests that are answered too late or never: those that are repeated in vain show that it goes on.
    NotServed,
    /// A request is not answered.
    Unanswered,
    /// A transfer violates the protocol.
    Violation,
    /// It stands for many rules.
    ManyRules,
    /// Its findings of one rule are one problem.
    OneRule,
    /// A write is refused.
    Refusal,
    /// A master does not start its node for it.
    CutsBoot,
    /// A program download fails.
    Program,
    /// Frames of its node, or to it, are missing.
    FramesMissing,
    /// Frames of its node are missing.
    OwnFramesMissing,
    /// A PDO is missing.
    MissingPdo,
    /// Frames that are due never came; the recorder may have left them out.
    Absent,
    /// Its node may stop its PDOs.
    StopsPdos,
    /// Its node waits for a PDO.
    AwaitsPdo,
    /// A PDO is not as intended.
    OtherPdo,
    /// A PDO has another length.
    WrongLength,
    /// A PDO is configured wrongly.
    PdoSetting,
    /// A lost configuration may cause it.
    OldConfiguration,
    /// RPDOs go to a node that is not Operational.
    RpdosIgnored,
    /// No RPDO takes the frames.
    NoReceiver,
    /// Those of SYNC are one problem.
    Sync,
    /// SYNC has stopped.
    NoSync,
    /// SYNC is irregular.
    UnsteadySync,
    /// There are two SYNC producers.
    TwoSyncs,
    /// A drive stops.
    DriveStops,
    /// A drive stops without a fault.
    Reaction,
    /// A drive is in fault.
    Fault,
    /// A drive does a quick stop.
    QuickStop,
    /// A fault reset has no edge.
    EdgeMissing,
    /// A fault that persists may cause it.
    FaultStays,
    /// A drive is not enabled.
    EnableIgnored,
    /// It may be reported before a fault.
    AnnouncesFault,
    /// Set-points come irregularly.
    Jitter,
    /// An axis lags.
    Lags,
    /// A supply voltage is wrong.
    Supply,
    /// Its own frames show it.
    ComparedAlone,
    /// Frames shortly before explain it.
    ComparedInContext,
    /// A device reports it.
    Error,
}

/// The facts that tell possible causes apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Apart {
    /// Only those of a refused write.
    Refusal,
    /// The return of nodes, the losses of others, and the noise.
    Loss,
    /// The errors before, and the noise.
    NoAnswer,
    /// The first frame of the node, and the noise.
    Absence,
    /// The other frames of the node.
    OtherFrames,
    /// The error code, the other axes, and losses before.
    Error,
    /// The time of the consumer.
    Report,
    /// The presence of the node.
    Presence,
}
