//! Eight problems of one sparsity pattern side by side: every operation acts on one entry of each.
//!
//! The entries are a SIMD register (or two) of the instruction set `S`. No lane depends on another,
//! so each has the bits of its own single solve. Plain arrays would do in principle, but the compiler
//! shuffles them across kernels' unrolled loops instead of keeping a lane in its place.

use super::scalar::{Decide, Real};
use core::ops::{Add, Div, Mul, Neg, Sub};
use pulp::{bytemuck, Scalar512b, Simd};

/// An instruction set with eight double-precision lanes.
pub trait EightLanes: Simd {
    /// As [`Real::TILE_COLS`].
    const TILE_COLS: usize;
    /// As [`Real::RHS_BLOCK`].
    const RHS_BLOCK: bool = false;
    /// Proof that this machine has it. Only asked for where it does.
    fn token() -> Self;
}

impl EightLanes for Scalar512b {
    const TILE_COLS: usize = 2;

    #[inline(always)]
    fn token() -> Self {
        Self
    }
}

#[cfg(target_arch = "x86_64")]
impl EightLanes for pulp::x86::V3_512b {
    // An entry takes two of the sixteen.
    const TILE_COLS: usize = 2;

    #[inline(always)]
    fn token() -> Self {
        match pulp::x86::V3::try_new() {
            Some(simd) => Self(simd),
            None => unreachable!("lanes of an instruction set that this machine lacks"),
        }
    }
}

#[cfg(target_arch = "x86_64")]
impl EightLanes for pulp::x86::V4 {
    const TILE_COLS: usize = 4;
    const RHS_BLOCK: bool = true;

    #[inline(always)]
    fn token() -> Self {
        match Self::try_new() {
            Some(simd) => simd,
            None => unreachable!("lanes of an instruction set that this machine lacks"),
        }
    }
}

/// One entry of each of eight problems. Aligned to a cache line: one that straddled two would cost every load
/// of it twice, and every store more.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Lanes<S: Simd> {
    simd: S,
    entries: S::f64s,
}

/// One comparison outcome of each of eight problems.
#[derive(Clone, Copy)]
pub struct LanesMask<S: Simd>(S::m64s);

macro_rules! lanewise {
    ($trait:ident, $method:ident, $op:ident) => {
        impl<S: Simd> $trait for Lanes<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self { entries: self.simd.$op(self.entries, other.entries), ..self }
            }
        }
    };
}

lanewise!(Add, add, add_f64s);
lanewise!(Sub, sub, sub_f64s);
lanewise!(Mul, mul, mul_f64s);
lanewise!(Div, div, div_f64s);

impl<S: Simd> Neg for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // The crate's own negation and magnitude are not inlined into what is compiled for the instruction set.
        Self { entries: self.simd.xor_f64s(self.entries, self.simd.splat_f64s(-0.0)), ..self }
    }
}

impl<S: EightLanes> Real for Lanes<S> {
    type Mask = LanesMask<S>;
    const TILE_COLS: usize = S::TILE_COLS;
    const RHS_BLOCK: bool = S::RHS_BLOCK;

    #[inline(always)]
    fn vectorize<W: pulp::WithSimd>(work: W) -> W::Output {
        S::token().vectorize(work)
    }

    #[inline(always)]
    fn is_down(flag: Self) -> bool {
        (0..Self::LANES).all(|lane| flag.lane(lane) == 0.0)
    }

    #[inline(always)]
    fn constant(value: f64) -> Self {
        let simd = S::token();
        Self { simd, entries: simd.splat_f64s(value) }
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self { entries: self.simd.sqrt_f64s(self.entries), ..self }
    }
    #[inline(always)]
    fn abs(self) -> Self {
        let magnitude = self.simd.splat_f64s(f64::from_bits(u64::MAX >> 1));
        Self { entries: self.simd.and_f64s(self.entries, magnitude), ..self }
    }
    #[inline(always)]
    fn lt(self, other: Self) -> LanesMask<S> {
        LanesMask(self.simd.less_than_f64s(self.entries, other.entries))
    }
    #[inline(always)]
    fn and(a: LanesMask<S>, b: LanesMask<S>) -> LanesMask<S> {
        LanesMask(S::token().and_m64s(a.0, b.0))
    }
    #[inline(always)]
    fn select(mask: LanesMask<S>, yes: Self, no: Self) -> Self {
        Self { entries: yes.simd.select_f64s(mask.0, yes.entries, no.entries), ..yes }
    }
}

impl<S: EightLanes> Decide for Lanes<S> {
    const LANES: usize = 8;

    #[inline(always)]
    fn lane(&self, lane: usize) -> f64 {
        let entries: &[f64] = bytemuck::cast_slice(core::slice::from_ref(&self.entries));
        entries[lane]
    }
    #[inline(always)]
    fn set_lane(&mut self, lane: usize, value: f64) {
        let entries: &mut [f64] = bytemuck::cast_slice_mut(core::slice::from_mut(&mut self.entries));
        entries[lane] = value;
    }
    fn epsilon() -> f64 {
        f64::EPSILON
    }
}
