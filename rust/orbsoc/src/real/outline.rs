//! Arithmetic compiled as a function of its own.

use super::scalar::Real;

/// Arithmetic that is compiled as a function of its own, by [`apart`].
pub(crate) trait Apart {
    /// Do it; `#[inline(always)]`, as a kernel.
    fn run(self);
}

/// Do what a kernel does rarely apart from it, for the same instruction set: loops of one function share its registers.
#[inline(always)]
pub(crate) fn apart<T: Real>(work: impl Apart) {
    T::vectorize(Dispatched(work));
}

struct Dispatched<W>(W);

impl<W: Apart> pulp::WithSimd for Dispatched<W> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        self.0.run();
    }
}
