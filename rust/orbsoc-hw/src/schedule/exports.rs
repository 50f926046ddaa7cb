//! Reservation of the network between clusters: in a cycle each cluster exports one word from each replica, and one result.

use super::reads::Reads;
use crate::machine::configuration::Configuration;

/// What leaves the clusters, cycle by cycle. One cluster exports nothing.
#[derive(Clone, Debug)]
pub(crate) struct Exports {
    clusters: usize,
    /// The cluster of each bank, and the banks of each cluster, as bits.
    cluster_of: Vec<u8>,
    banks_of: Vec<u64>,
    /// For each cycle and cluster the value exported from each replica, counted from one; 0: none.
    words: Vec<[u32; 3]>,
    /// For each cycle the clusters that export a result, as bits.
    results: Vec<u16>,
}

impl Exports {
    pub fn new(configuration: &Configuration) -> Self {
        let clusters = configuration.clusters;
        let cluster_of: Vec<u8> =
            (0..configuration.banks).map(|bank| configuration.cluster_of_bank(bank) as u8).collect();
        let mut banks_of = vec![0; clusters];
        cluster_of
            .iter()
            .enumerate()
            .for_each(|(bank, &cluster)| banks_of[usize::from(cluster)] |= 1 << bank);
        Self { clusters, cluster_of, banks_of, words: Vec::new(), results: Vec::new() }
    }

    /// The banks of a cluster, as bits.
    pub fn banks_of(&self, cluster: usize) -> u64 {
        self.banks_of[cluster]
    }

    /// The replicas that are read in another cluster, with that cluster.
    fn imports<'a>(&'a self, reads: &'a Reads, cluster: usize) -> impl Iterator<Item = (usize, usize)> + 'a {
        let source =
            |&bank: &u64| (bank != 0).then(|| usize::from(self.cluster_of[bank.trailing_zeros() as usize]));
        let sources = reads.banks.iter().map(source).enumerate();
        sources
            .filter_map(move |(replica, source)| Some((replica, source.filter(|&source| source != cluster)?)))
    }

    /// Whether the words that a cluster reads in others can be exported in a cycle.
    pub fn may_read(&self, cycle: u32, reads: &Reads, cluster: usize) -> bool {
        self.clusters == 1
            || self.imports(reads, cluster).all(|(replica, source)| {
                let exported =
                    self.words.get(cycle as usize * self.clusters + source).map_or(0, |word| word[replica]);
                exported == 0 || exported == reads.values[replica] + 1
            })
    }

    /// Whether a cluster's result can be exported in the cycle in which it appears.
    pub fn may_write(&self, cycle: u32, cluster: usize) -> bool {
        self.clusters > 1 && self.results.get(cycle as usize).is_none_or(|taken| taken >> cluster & 1 == 0)
    }

    /// Export what an operation of a cluster reads in others.
    pub fn take_words(&mut self, cycle: u32, reads: &Reads, cluster: usize) {
        if self.clusters == 1 {
            return;
        }
        let first = cycle as usize * self.clusters;
        if self.words.len() < first + self.clusters {
            self.words.resize(first + self.clusters, [0; 3]);
        }
        let imports: Vec<_> = self.imports(reads, cluster).collect();
        for (replica, source) in imports {
            self.words[first + source][replica] = reads.values[replica] + 1;
        }
    }

    /// Export a result, if its bank is another cluster's.
    pub fn take_result(&mut self, cycle: u32, bank: usize, cluster: usize) {
        if usize::from(self.cluster_of[bank]) == cluster {
            return;
        }
        if self.results.len() <= cycle as usize {
            self.results.resize(cycle as usize + 1, 0);
        }
        self.results[cycle as usize] |= 1 << cluster;
    }
}
