//! The time that a run takes. On `wasm32-unknown-unknown` there is no clock, and every duration is zero.

#[cfg(not(all(target_arch = "wasm32", target_os = "unknown")))]
pub use std::time::Instant;

#[cfg(all(target_arch = "wasm32", target_os = "unknown"))]
pub use without::Instant;

#[cfg(all(target_arch = "wasm32", target_os = "unknown"))]
mod without {
    use std::time::Duration;

    /// A clock that never advances, for targets without one.
    #[derive(Clone, Copy, Debug)]
    pub struct Instant;

    impl Instant {
        /// This moment.
        pub fn now() -> Instant {
            Instant
        }

        /// No time.
        pub fn elapsed(&self) -> Duration {
            Duration::ZERO
        }
    }

    impl std::ops::Sub for Instant {
        type Output = Duration;

        fn sub(self, _: Instant) -> Duration {
            Duration::ZERO
        }
    }
}
