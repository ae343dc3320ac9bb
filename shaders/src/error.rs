//! What can go wrong on a device.

/// Why work on a device did not finish.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GpuError {
    /// There is no adapter that could be used.
    #[error("{0}")]
    NoAdapter(String),
    /// The device is gone: the driver was reset, or the card was taken away. Its work can go on elsewhere.
    #[error("the compute device was lost ({0})")]
    Lost(String),
    /// The work does not fit into the device's memory, or the budget that it was given.
    #[error("{0}")]
    OutOfMemory(String),
    /// The driver or the validation layer refused something: a defect of this program.
    #[error("the compute device refused: {0}")]
    Refused(String),
    /// Whoever asked for the work asked it to stop.
    #[error("cancelled")]
    Cancelled,
}
