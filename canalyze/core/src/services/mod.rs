//! The services whose frames need more than themselves: PDO, whose content its mapping defines, and SDO, whose frames
//! need their channel's history. Every other service is in `wire`.

pub mod pdo;
pub mod sdo;
