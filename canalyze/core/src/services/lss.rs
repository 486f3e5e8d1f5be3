//! LSS, layer setting services (CiA 305): one frame's command.

/// An LSS command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// A command specifier that CiA 305 does not define.
    Unknown(u8),
}
