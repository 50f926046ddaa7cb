//! Identity: one number for everything of an engine that a program depends on, so that no other engine takes it.

use super::configuration::Configuration;
use super::timing::{Precision, Timing};
use crate::error::Error;

const VERSION: u32 = 1;
const BASIS: u32 = 0x811c_9dc5;
const PRIME: u32 = 16_777_619;

impl Configuration {
    /// The RTL's own number of this engine (`axi_contract::identity`): FNV-1a over whole words. Two engines that differ in one
    /// of them never have the same. The latencies are the RTL's, also where a test schedules for wrong ones.
    /// Rows of a bank stand above the bits of an address, where they are fewer than those reach.
    /// `format`: 0 flat microcode, 1 compressed, and with streamed microcode twice the number of its ports more.
    pub fn identity(&self, format: u32) -> u32 {
        let timing = Timing::of(self.precision);
        let fewer = if self.rows() == self.rows_in_reach() { 0 } else { self.rows() as u32 };
        let shape = [self.lanes, self.dividers, self.banks, self.clusters].map(|count| count as u32);
        let words = [VERSION, self.precision.bits()]
            .into_iter()
            .chain(shape)
            .chain([self.address_bits | fewer << 8, format])
            .chain(timing.contract());
        words.fold(BASIS, |hash, word| (hash ^ word).wrapping_mul(PRIME))
    }

    /// # Errors
    /// [`Error::OtherEngine`] unless an engine has the identity of this one.
    pub fn require_identity(&self, format: u32, there: u32) -> Result<(), Error> {
        let expected = self.identity(format);
        if there == expected {
            return Ok(());
        }
        let precision = if self.precision == Precision::F64 { "binary64" } else { "binary32" };
        let format = match format {
            0 => "flat".to_owned(),
            1 => "compressed".to_owned(),
            more => format!("compressed and by {} ports streamed", more / 2),
        };
        let words = match self.rows {
            None => format!("2^{}", self.address_bits),
            Some(rows) => format!("{} x {rows}", self.banks),
        };
        let engine = format!(
            "{precision}, {} lanes, {} dividers, {} banks in {} clusters, {} words, {format} microcode",
            self.lanes, self.dividers, self.banks, self.clusters, words
        );
        Err(Error::OtherEngine { engine, expected, found: there })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn engines_that_differ_in_anything_are_told_apart() {
        let base = Configuration::default();
        let others = [
            base,
            Configuration { lanes: 3, ..base },
            Configuration { dividers: 2, ..base },
            Configuration { banks: 4, ..base },
            Configuration { clusters: 4, ..base },
            Configuration { address_bits: 14, ..base },
            Configuration { rows: Some(1500), ..base },
            Configuration { rows: Some(1501), ..base },
            Configuration { precision: Precision::F32, ..base },
        ];
        let found: Vec<(Configuration, u32, u32)> = others
            .iter()
            .flat_map(|one| [0, 1, 3, 5].map(|format| (*one, format, one.identity(format))))
            .collect();
        for (k, (one, format, _)) in found.iter().enumerate() {
            for (j, (_, _, identity)) in found.iter().enumerate() {
                assert_eq!(one.require_identity(*format, *identity).is_ok(), k == j);
            }
        }
    }

    #[test]
    fn a_refusal_says_whose_the_program_is() {
        let refused = Configuration::default().require_identity(0, 7).unwrap_err().to_string();
        assert!(
            refused.contains("4 lanes, 1 dividers, 16 banks in 1 clusters, 2^15 words, flat"),
            "{refused}"
        );
    }
}
