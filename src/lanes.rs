//! Lanes and the instruction set they run on.
//!
//! A kernel is a plain loop over slices. [`Isa::run`] runs it compiled for an instruction set that is
//! chosen when the program starts: the baseline of the target, AVX2 or AVX-512. No kernel uses a fused
//! multiply-add and Rust contracts nothing, so every instruction set gives the same bits (of a NaN only
//! that it is one: its sign and payload are not defined).
//!
//! Whatever a kernel calls in its loops must be `#[inline(always)]`: code that is not inlined into it is
//! compiled for the baseline. This includes functions of the standard library. `std::array::from_fn`,
//! `[T; N]::map` and `Iterator::zip` are only inlined by link-time optimisation, which the build of a program
//! that embeds this library may not have; [`array()`] takes their place.

// Loops over lanes index several arrays at once.
#![allow(clippy::needless_range_loop)]

use pulp::{Arch, Simd, WithSimd};

/// The instruction set that kernels are compiled for.
#[derive(Clone, Copy, Debug)]
pub struct Isa(Arch);

impl PartialEq for Isa {
    fn eq(&self, other: &Isa) -> bool {
        self.name() == other.name()
    }
}

impl Eq for Isa {}

impl Isa {
    /// The one that is expected to be the fastest on this machine.
    ///
    /// AVX-512 is chosen only where the processor also has its second extension of byte operations (VBMI2), which
    /// came with Ice Lake and Zen 4. The server processors before those lower their clock while they run 512-bit
    /// instructions, so that everything between kernels is slower.
    pub fn detect() -> Isa {
        Isa::avx512().filter(|_| keeps_clock_with_avx512()).or(Isa::avx2()).unwrap_or(Isa(Arch::new()))
    }

    /// The one that every machine of the target has.
    pub fn baseline() -> Isa {
        Isa(Arch::Scalar)
    }

    /// AVX2, if this machine has it.
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    fn avx2() -> Option<Isa> {
        pulp::x86::V3::try_new().map(|v3| Isa(Arch::V3(v3)))
    }

    /// AVX-512, if this machine has it.
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    fn avx512() -> Option<Isa> {
        pulp::x86::V4::try_new().map(|v4| Isa(Arch::V4(v4)))
    }

    #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
    fn avx2() -> Option<Isa> {
        None
    }

    #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
    fn avx512() -> Option<Isa> {
        None
    }

    /// All that this machine has, the baseline first.
    pub fn all() -> impl Iterator<Item = Isa> {
        let native = Some(Isa::detect()).filter(|isa| isa.name() == "native");
        [Some(Isa::baseline()), Isa::avx2(), Isa::avx512(), native].into_iter().flatten()
    }

    /// From the names `auto`, `baseline`, `avx2` and `avx512`.
    ///
    /// # Errors
    /// If there is no such name, or if this machine does not have the instruction set.
    pub fn from_name(name: &str) -> Result<Isa, String> {
        let had = |isa: Option<Isa>, what: &str| isa.ok_or_else(|| format!("this machine has no {what}"));
        match name {
            "auto" => Ok(Isa::detect()),
            "baseline" => Ok(Isa::baseline()),
            "avx2" => had(Isa::avx2(), "AVX2"),
            "avx512" => had(Isa::avx512(), "AVX-512"),
            _ => Err(format!("no instruction set `{name}`; there are auto, baseline, avx2 and avx512")),
        }
    }

    /// `baseline`, `avx2`, `avx512`, or `native` for what another architecture has.
    pub fn name(self) -> &'static str {
        match self.0 {
            Arch::Scalar => "baseline",
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Arch::V3(_) => "avx2",
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Arch::V4(_) => "avx512",
            #[allow(unreachable_patterns)]
            _ => "native",
        }
    }

    /// Runs a kernel compiled for this instruction set.
    ///
    /// Only what is inlined into it is compiled so. A large closure may not be: give those as a struct
    /// with an `#[inline(always)]` [`Kernel::run`].
    #[inline]
    pub fn run<K: Kernel>(self, kernel: K) -> K::Output {
        self.0.dispatch(OnArch(kernel))
    }
}

/// Whether the processor runs 512-bit instructions without lowering its clock: see [`Isa::detect`].
fn keeps_clock_with_avx512() -> bool {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    return std::arch::is_x86_feature_detected!("avx512vbmi2");
    #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
    false
}

impl Default for Isa {
    fn default() -> Isa {
        Isa::detect()
    }
}

/// A piece of work that can be compiled for several instruction sets.
pub trait Kernel {
    /// What it gives back.
    type Output;
    /// Does it. Must be `#[inline(always)]`, and all it calls in its loops too.
    fn run(self) -> Self::Output;
}

impl<R, F: FnOnce() -> R> Kernel for F {
    type Output = R;
    #[inline(always)]
    fn run(self) -> R {
        self()
    }
}

/// Makes a [`Kernel`] known to `pulp`.
struct OnArch<K>(K);

impl<K: Kernel> WithSimd for OnArch<K> {
    type Output = K::Output;
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> K::Output {
        self.0.run()
    }
}

/// `[f(0), f(1), …]`: `std::array::from_fn` for kernels, inlined in every build. `N` must not be 0.
#[inline(always)]
pub fn array<T: Copy, const N: usize>(mut f: impl FnMut(usize) -> T) -> [T; N] {
    const { assert!(N > 0) };
    let mut all = [f(0); N];
    let mut k = 1;
    while k < N {
        all[k] = f(k);
        k += 1;
    }
    all
}

/// An operand: one value for all lanes, or one a lane.
#[derive(Clone, Copy, Debug)]
pub enum Arg<'a> {
    /// The same in every lane.
    Uniform(f32),
    /// As long as the output.
    Varying(&'a [f32]),
}

impl Arg<'_> {
    /// The value in a lane.
    #[inline(always)]
    pub fn get(self, lane: usize) -> f32 {
        match self {
            Arg::Uniform(value) => value,
            Arg::Varying(lanes) => lanes[lane],
        }
    }
}

/// `out[i] = f(a[i])`. `f` should be `#[inline(always)]`.
///
/// # Panics
/// If the lengths differ.
#[inline]
pub fn map1<F: Fn(f32) -> f32 + Copy>(isa: Isa, a: &[f32], out: &mut [f32], f: F) {
    isa.run(Map { args: [a], out, f: |[x]: [f32; 1]| f(x) });
}

/// `out[i] = f(a[i], b[i])`; two uniform operands are computed once.
///
/// # Panics
/// If the lengths differ.
#[inline]
pub fn map2<F: Fn(f32, f32) -> f32 + Copy>(isa: Isa, a: Arg, b: Arg, out: &mut [f32], f: F) {
    match (a, b) {
        (Arg::Uniform(a), Arg::Uniform(b)) => out.fill(f(a, b)),
        (Arg::Uniform(a), Arg::Varying(b)) => isa.run(Map { args: [b], out, f: |[y]: [f32; 1]| f(a, y) }),
        (Arg::Varying(a), Arg::Uniform(b)) => isa.run(Map { args: [a], out, f: |[x]: [f32; 1]| f(x, b) }),
        (Arg::Varying(a), Arg::Varying(b)) => {
            isa.run(Map { args: [a, b], out, f: |[x, y]: [f32; 2]| f(x, y) })
        }
    }
}

/// `out[i] = f(a[i], b[i], c[i])`; three uniform operands are computed once.
///
/// # Panics
/// If the lengths differ.
#[inline]
pub fn map3<F: Fn(f32, f32, f32) -> f32 + Copy>(isa: Isa, a: Arg, b: Arg, c: Arg, out: &mut [f32], f: F) {
    use Arg::{Uniform, Varying};
    match (a, b, c) {
        (Uniform(a), b, c) => map2(isa, b, c, out, move |y, z| f(a, y, z)),
        (a, Uniform(b), c) => map2(isa, a, c, out, move |x, z| f(x, b, z)),
        (a, b, Uniform(c)) => map2(isa, a, b, out, move |x, y| f(x, y, c)),
        (Varying(a), Varying(b), Varying(c)) => {
            isa.run(Map { args: [a, b, c], out, f: |[x, y, z]: [f32; 3]| f(x, y, z) })
        }
    }
}

/// Does any lane satisfy it?
#[inline]
pub fn any1<F: Fn(f32) -> bool + Copy>(isa: Isa, a: &[f32], f: F) -> bool {
    isa.run(Any { lanes: a, f })
}

/// The loop under every map.
struct Map<'a, const N: usize, F> {
    args: [&'a [f32]; N],
    out: &'a mut [f32],
    f: F,
}

impl<const N: usize, F: Fn([f32; N]) -> f32> Kernel for Map<'_, N, F> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let n = self.out.len();
        assert!(self.args.iter().all(|arg| arg.len() == n), "lanes of different lengths");
        // Slices of the very length of the output need no check of bounds in the loop.
        let args: [&[f32]; N] = array(|k| &self.args[k][..n]);
        for i in 0..n {
            self.out[i] = (self.f)(array(|k| args[k][i]));
        }
    }
}

/// The loop under [`any1`]: it never leaves early, so that it vectorises.
struct Any<'a, F> {
    lanes: &'a [f32],
    f: F,
}

impl<F: Fn(f32) -> bool> Kernel for Any<'_, F> {
    type Output = bool;
    #[inline(always)]
    fn run(self) -> bool {
        self.lanes.iter().fold(0_u32, |any, &x| any | u32::from((self.f)(x))) != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn add3(x: f32, y: f32, z: f32) -> f32 {
        x + 2.0 * y + 4.0 * z
    }

    #[test]
    fn names_are_understood() {
        assert_eq!(Isa::from_name("baseline").unwrap().name(), "baseline");
        assert_eq!(Isa::from_name("auto").unwrap().name(), Isa::detect().name());
        for isa in Isa::all().filter(|isa| isa.name() != "native") {
            assert_eq!(Isa::from_name(isa.name()).unwrap().name(), isa.name());
        }
        assert!(Isa::from_name("sse9").unwrap_err().contains("sse9"));
    }

    #[test]
    fn every_mix_of_uniform_and_varying_agrees() {
        let lanes: Vec<f32> = (0..257).map(|i| i as f32 - 100.0).collect();
        for n in [0, 1, 7, 255, 256, 257] {
            for mix in 0..8 {
                let arg = |bit: i32| {
                    if mix >> bit & 1 == 1 { Arg::Varying(&lanes[..n]) } else { Arg::Uniform(3.5) }
                };
                let (a, b, c) = (arg(0), arg(1), arg(2));
                let mut out = vec![0.0; n];
                map3(Isa::detect(), a, b, c, &mut out, add3);
                for (i, &o) in out.iter().enumerate() {
                    assert_eq!(o, add3(a.get(i), b.get(i), c.get(i)));
                }
            }
        }
    }

    #[test]
    fn any_sees_the_last_lane() {
        let mut lanes = vec![0.0; 257];
        assert!(!any1(Isa::detect(), &lanes, |x| x > 1.0));
        lanes[256] = 2.0;
        assert!(any1(Isa::detect(), &lanes, |x| x > 1.0));
    }
}
