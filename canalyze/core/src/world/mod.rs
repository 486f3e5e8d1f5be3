//! The bus as the capture shows it: objects and configuration of devices, nodes, roles of COB-IDs, and what each frame
//! means given all before it.

pub mod bus;
pub mod change;
pub mod configuration;
pub mod context;
pub mod dictionary;
pub mod drive;
pub mod event;
pub mod network;
pub mod node;
pub mod od;
pub mod preset;
pub mod profile_defaults;
pub mod repeats;
pub mod roles;
