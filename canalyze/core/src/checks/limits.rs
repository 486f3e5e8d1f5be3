//! Times of devices that several checks use, in ns. Those of SDO are in `sdo::limits`.

use crate::bytes::ns::Ns;

/// Maximum time of a boot-up after a reset: CiA 301 and CiA 305 set no limit, real nodes take well below 2 s.
pub const BOOT_NS: Ns = Ns::from_s(3);
/// Nodes switched on together have booted within this time.
pub const POWER_UP_NS: Ns = Ns::from_s(5);
/// Maximum time between a fault of a drive and its EMCY, whichever comes first.
pub const FAULT_EMCY_NS: Ns = Ns::from_ms(500);
/// Faults of several axes of one device within this time have one cause.
pub const FAULTS_TOGETHER_NS: Ns = Ns::from_ms(100);
/// A problem that returns within this time after its end is the same one.
pub const AGAIN_NS: Ns = Ns::from_s(10);
/// Time without any SYNC, where one is due, after which none is produced.
pub const NO_SYNC_NS: Ns = Ns::from_s(5);
