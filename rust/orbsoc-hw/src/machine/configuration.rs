//! Parameters of an engine.

use super::timing::{Precision, Timing};
use crate::error::Error;

/// Parameters of one engine. Two engines with equal parameters run the same microcode in the same cycles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Configuration {
    /// Word format.
    pub precision: Precision,
    /// Lanes of multiply then add.
    pub lanes: usize,
    /// Divide and square-root units.
    pub dividers: usize,
    /// Banks of storage.
    pub banks: usize,
    /// Words of storage: two to this.
    pub address_bits: u32,
    /// Words that the microcode memory holds, of all segments together.
    pub microcode_words: usize,
    /// Latencies to schedule for; `None`: the RTL's. Tests use wrong ones to show that validation finds them.
    pub timing: Option<Timing>,
}

impl Default for Configuration {
    fn default() -> Self {
        Self {
            precision: Precision::F64,
            lanes: 4,
            dividers: 1,
            banks: 16,
            address_bits: 15,
            microcode_words: 1 << 20,
            timing: None,
        }
    }
}

impl Configuration {
    /// # Errors
    /// The first field that no engine can have.
    pub fn validate(&self) -> Result<(), Error> {
        let check = |ok: bool, field, value: usize, allowed| {
            let value = value as u64;
            if ok {
                Ok(())
            } else {
                Err(Error::Configuration { field, value, allowed })
            }
        };
        check((1..=16).contains(&self.lanes), "lanes", self.lanes, "1 to 16")?;
        check((1..=4).contains(&self.dividers), "dividers", self.dividers, "1 to 4")?;
        let banks = self.banks.is_power_of_two() && (2..=64).contains(&self.banks);
        check(banks, "banks", self.banks, "a power of two from 2 to 64")?;
        let bits = (8..=20).contains(&self.address_bits);
        check(bits, "address_bits", self.address_bits as usize, "8 to 20")?;
        check(self.microcode_words >= 1, "microcode_words", self.microcode_words, "1 or more")
    }

    /// Words of storage.
    pub fn words(&self) -> usize {
        1 << self.address_bits
    }

    /// The bank of a word.
    pub fn bank(&self, address: u32) -> usize {
        address as usize & (self.banks - 1)
    }

    /// Latencies of its units.
    pub fn timing(&self) -> &Timing {
        self.timing.as_ref().unwrap_or_else(|| Timing::of(self.precision))
    }

    /// Bits of a flat microcode word.
    pub fn flat_bits(&self) -> usize {
        let a = self.address_bits as usize;
        1 + self.lanes * (4 * a + 4) + self.dividers * (3 * a + 2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn engines_that_cannot_exist_are_refused_by_field() {
        let good = Configuration::default();
        good.validate().unwrap();
        let refused = |bad: Configuration| match bad.validate() {
            Err(Error::Configuration { field, .. }) => field,
            other => panic!("{other:?}"),
        };
        assert_eq!(refused(Configuration { lanes: 0, ..good }), "lanes");
        assert_eq!(refused(Configuration { dividers: 0, ..good }), "dividers");
        assert_eq!(refused(Configuration { banks: 12, ..good }), "banks");
        assert_eq!(refused(Configuration { banks: 1, ..good }), "banks");
        assert_eq!(refused(Configuration { address_bits: 40, ..good }), "address_bits");
        assert_eq!(refused(Configuration { microcode_words: 0, ..good }), "microcode_words");
    }

    #[test]
    fn the_flat_word_has_the_contracts_width() {
        let four = Configuration { address_bits: 14, ..Configuration::default() };
        assert_eq!(four.flat_bits(), 1 + 4 * 60 + 44);
    }
}
