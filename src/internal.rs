//! What the `pse` command, its tests and its benchmarks share with the library. Nothing here is part of the
//! library's interface: any release may change it.

#[allow(missing_docs)]
pub mod assist {
    pub use crate::assist::*;
}
#[allow(missing_docs)]
pub mod builtin {
    pub use crate::builtin::*;
}
#[allow(missing_docs)]
pub mod diagnostic {
    pub use crate::diagnostic::*;
}
#[allow(missing_docs)]
pub mod eval {
    pub use crate::eval::*;
}
#[cfg(feature = "exr")]
#[allow(missing_docs)]
pub mod files {
    pub use crate::files::*;
}
#[allow(missing_docs)]
pub mod host {
    pub use crate::host::*;
}
#[allow(missing_docs)]
pub mod lanes {
    pub use crate::lanes::*;
}
#[allow(missing_docs)]
pub mod math {
    pub use crate::math::*;
}
#[allow(missing_docs)]
pub mod program {
    pub use crate::program::*;
}
#[allow(missing_docs)]
pub mod quote {
    pub use crate::quote::*;
}
#[allow(missing_docs)]
pub mod reference {
    pub use crate::reference::*;
}
#[allow(missing_docs)]
pub mod resolve {
    pub use crate::resolve::*;
}
#[allow(missing_docs)]
pub mod shape {
    pub use crate::shape::*;
}
#[allow(missing_docs)]
pub mod spelling {
    pub use crate::spelling::*;
}
#[allow(missing_docs)]
pub mod syntax {
    pub use crate::syntax::*;
}
#[allow(missing_docs)]
pub mod texture {
    pub use crate::texture::*;
}
#[allow(missing_docs)]
pub mod value {
    pub use crate::value::*;
}
#[allow(missing_docs)]
pub mod visible {
    pub use crate::visible::*;
}
#[allow(missing_docs)]
pub mod vocabulary {
    pub use crate::vocabulary::*;
}
