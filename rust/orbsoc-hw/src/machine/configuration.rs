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
    /// Clusters of lanes and banks, with a narrow network between.
    pub clusters: usize,
    /// Bits of an address: words of storage are two to this, or fewer.
    pub address_bits: u32,
    /// Rows of a bank; `None`: as many as addresses reach.
    pub rows: Option<usize>,
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
            clusters: 1,
            address_bits: 15,
            rows: None,
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
        let clusters = self.clusters;
        let divides = [1, 2, 4, 8].contains(&clusters)
            && self.lanes.is_multiple_of(clusters)
            && self.banks >= 2 * clusters;
        check(divides, "clusters", clusters, "1, 2, 4 or 8, a divisor of the lanes, with two banks each")?;
        let bits = (8..=20).contains(&self.address_bits);
        check(bits, "address_bits", self.address_bits as usize, "8 to 20")?;
        let rows = self.rows();
        let reached = (1..=self.rows_in_reach()).contains(&rows);
        check(reached, "rows", rows, "1 to what `address_bits` reach in each bank")?;
        check(self.microcode_words >= 1, "microcode_words", self.microcode_words, "1 or more")
    }

    /// # Errors
    /// Clusters: the in-order sequencer knows nothing of the network between them.
    pub fn require_in_order(&self) -> Result<(), Error> {
        let clusters = self.clusters as u64;
        let wrong = Error::Configuration {
            field: "clusters",
            value: clusters,
            allowed: "1 with an in-order sequencer",
        };
        if clusters == 1 {
            Ok(())
        } else {
            Err(wrong)
        }
    }

    /// Rows of a bank.
    pub fn rows(&self) -> usize {
        self.rows.unwrap_or(self.rows_in_reach())
    }

    /// Rows that addresses tell apart.
    pub fn rows_in_reach(&self) -> usize {
        (1 << self.address_bits) / self.banks
    }

    /// Words of storage.
    pub fn words(&self) -> usize {
        self.rows() * self.banks
    }

    /// The field that limits the words of storage.
    pub(crate) fn storage_key(&self) -> &'static str {
        self.rows.map_or("address_bits", |_| "rows")
    }

    /// The bank of a word.
    pub fn bank(&self, address: u32) -> usize {
        address as usize & (self.banks - 1)
    }

    /// The cluster of a bank: neighbouring words lie in neighbouring clusters.
    pub fn cluster_of_bank(&self, bank: usize) -> usize {
        bank & (self.clusters - 1)
    }

    /// The cluster of a unit.
    pub fn cluster_of_unit(&self, on_divider: bool, unit: usize) -> usize {
        if on_divider {
            unit & (self.clusters - 1)
        } else {
            unit / (self.lanes / self.clusters)
        }
    }

    /// The lanes of a cluster, as bits.
    pub fn lanes_of_cluster(&self, cluster: usize) -> u32 {
        let each = self.lanes / self.clusters;
        ((1 << each) - 1) << (cluster * each)
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
        assert_eq!(refused(Configuration { clusters: 3, lanes: 3, ..good }), "clusters");
        assert_eq!(refused(Configuration { clusters: 8, ..good }), "clusters");
        assert_eq!(refused(Configuration { clusters: 4, banks: 4, ..good }), "clusters");
        let clustered = Configuration { clusters: 4, ..good };
        clustered.validate().unwrap();
        assert!(clustered.require_in_order().is_err());
        assert_eq!(refused(Configuration { address_bits: 40, ..good }), "address_bits");
        assert_eq!(refused(Configuration { rows: Some(0), ..good }), "rows");
        assert_eq!(refused(Configuration { rows: Some((1 << 11) + 1), ..good }), "rows");
        let exact = Configuration { rows: Some(1500), ..good };
        exact.validate().unwrap();
        assert_eq!(exact.words(), 1500 * 16);
        assert_eq!(refused(Configuration { microcode_words: 0, ..good }), "microcode_words");
    }

    #[test]
    fn every_unit_and_bank_is_in_one_cluster() {
        let engine =
            Configuration { lanes: 8, dividers: 3, banks: 16, clusters: 4, ..Configuration::default() };
        let lanes: Vec<usize> = (0..8).map(|lane| engine.cluster_of_unit(false, lane)).collect();
        assert_eq!(lanes, [0, 0, 1, 1, 2, 2, 3, 3]);
        assert_eq!([0, 1, 2].map(|divider| engine.cluster_of_unit(true, divider)), [0, 1, 2]);
        assert_eq!([0, 1, 4, 15].map(|bank| engine.cluster_of_bank(bank)), [0, 1, 0, 3]);
        let masks: Vec<u32> = (0..4).map(|cluster| engine.lanes_of_cluster(cluster)).collect();
        assert_eq!(masks, [3, 3 << 2, 3 << 4, 3 << 6]);
    }

    #[test]
    fn the_flat_word_has_the_contracts_width() {
        let four = Configuration { address_bits: 14, ..Configuration::default() };
        assert_eq!(four.flat_bits(), 1 + 4 * 60 + 44);
    }
}
