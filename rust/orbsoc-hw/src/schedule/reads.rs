//! What an operation reads.

/// What an operation reads in each replica: the bank, as a bit of a mask, and the value. No bit: no read. Equal values
/// share a port.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Reads {
    pub banks: [u64; 3],
    pub values: [u32; 3],
}

impl Reads {
    /// Read a value; equal words have equal numbers.
    pub fn set(&mut self, replica: usize, bank: u8, value: u32) {
        self.banks[replica] = 1 << bank;
        self.values[replica] = value;
    }

    /// Exchange a and b.
    pub fn swap(&mut self) {
        self.banks.swap(0, 1);
        self.values.swap(0, 1);
    }
}
