//! stub replaced at merge
/// isa
#[derive(Clone, Copy, Debug)]
pub struct Isa(pulp::Arch);
impl Isa {
    /// d
    pub fn detect() -> Isa {
        Isa(pulp::Arch::new())
    }
    /// b
    pub fn baseline() -> Isa {
        Isa(pulp::Arch::Scalar)
    }
    /// run
    #[inline(always)]
    pub fn run<R>(self, f: impl FnOnce() -> R) -> R {
        struct W<F>(F);
        impl<R, F: FnOnce() -> R> pulp::NullaryFnOnce for W<F> {
            type Output = R;
            #[inline(always)]
            fn call(self) -> R {
                (self.0)()
            }
        }
        self.0.dispatch(W(f))
    }
}
/// arg
#[derive(Clone, Copy, Debug)]
pub enum Arg<'a> {
    /// u
    Uniform(f32),
    /// v
    Varying(&'a [f32]),
}
/// m1
pub fn map1(isa: Isa, a: &[f32], out: &mut [f32], f: impl Fn(f32) -> f32 + Copy) {
    isa.run(|| {
        for (o, a) in out.iter_mut().zip(a) {
            *o = f(*a)
        }
    })
}
/// m2
pub fn map2(isa: Isa, a: Arg<'_>, b: Arg<'_>, out: &mut [f32], f: impl Fn(f32, f32) -> f32 + Copy) {
    isa.run(|| match (a, b) {
        (Arg::Varying(a), Arg::Varying(b)) => {
            for ((o, a), b) in out.iter_mut().zip(a).zip(b) {
                *o = f(*a, *b)
            }
        }
        (Arg::Varying(a), Arg::Uniform(b)) => {
            for (o, a) in out.iter_mut().zip(a) {
                *o = f(*a, b)
            }
        }
        (Arg::Uniform(a), Arg::Varying(b)) => {
            for (o, b) in out.iter_mut().zip(b) {
                *o = f(a, *b)
            }
        }
        (Arg::Uniform(a), Arg::Uniform(b)) => out.fill(f(a, b)),
    })
}
