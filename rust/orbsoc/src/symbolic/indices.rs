//! Indices, and what is sorted by them. They are entries of 32 bits, as in the lists that the numeric kernels follow.

/// Sizes were checked when the problem was made, and fill when it was analysed.
pub(crate) fn index(value: usize) -> u32 {
    u32::try_from(value).unwrap_or_else(|_| panic!("index {value} does not fit 32 bits"))
}

/// Where the items of each key begin, keys below `dim`, and where all end.
pub(crate) fn begins(dim: usize, keys: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut begins = vec![0; dim + 1];
    keys.for_each(|key| begins[key as usize + 1] += 1);
    let mut end = 0;
    for begin in &mut begins {
        end += *begin;
        *begin = end;
    }
    begins
}

/// Items in the order of their keys; equal ones stay in theirs.
pub(crate) fn ordered<T: Copy + Default>(begins: &[u32], items: impl Iterator<Item = (u32, T)>) -> Vec<T> {
    let mut next = begins.to_vec();
    let mut out = vec![T::default(); begins[begins.len() - 1] as usize];
    items.for_each(|(key, item)| {
        let place = &mut next[key as usize];
        out[*place as usize] = item;
        *place += 1;
    });
    out
}
