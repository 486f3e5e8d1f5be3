//! Times of devices that several checks use, in ns. Those of SDO are in `sdo::limits`.

/// Maximum time of a boot-up after a reset: CiA 301 and CiA 305 set no limit, real nodes take well below 2 s.
pub const BOOT_NS: i64 = 3_000_000_000;
/// Nodes switched on together have booted within this time.
pub const POWER_UP_NS: i64 = 5_000_000_000;
/// Maximum time between a fault of a drive and its EMCY, whichever comes first.
pub const FAULT_EMCY_NS: i64 = 500_000_000;
/// Faults of several axes of one device within this time have one cause.
pub const FAULTS_TOGETHER_NS: i64 = 100_000_000;
/// A problem that returns within this time after its end is the same one.
pub const AGAIN_NS: i64 = 10_000_000_000;
