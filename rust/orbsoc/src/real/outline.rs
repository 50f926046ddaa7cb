//! Arithmetic compiled as a function of its own.

use super::scalar::Real;

/// Arithmetic that is compiled as a function of its own, by [`outline`].
pub(crate) trait Outlined {
    /// Do it; `#[inline(always)]`, as a kernel.
    fn run(self);
}

/// Run `work` as a function of its own, for the same instruction set: loops of one function share its registers.
#[inline(always)]
pub(crate) fn outline<T: Real>(work: impl Outlined) {
    T::vectorize(Dispatched(work));
}

struct Dispatched<W>(W);

impl<W: Outlined> pulp::WithSimd for Dispatched<W> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        self.0.run();
    }
}
