//! The resolved program: names have become slots, calls know what they call, and every argument is in its place.

use crate::builtin::Builtin;
use crate::diagnostic::{Sources, Span};
use crate::eval::HostFunction;
use crate::texture;
use std::collections::BTreeSet;
use std::sync::Arc;

pub use crate::syntax::ast::{BinaryOp, UnaryOp};

/// A program, ready to be bound to an image and run. It never changes, and any number of threads may share it.
#[derive(Debug, Default)]
pub struct Resolved {
    /// The texts that spans point into.
    pub sources: Sources,
    /// The variables of the outer level; a [`Place::Global`] is an index into them.
    pub globals: Vec<Global>,
    /// The functions that are called, the program's own and the library's.
    pub functions: Vec<Function>,
    /// `param` declarations in order.
    pub params: Vec<Param>,
    /// What runs once a frame: the blocks of `if begin_frame`.
    pub frame: Vec<Stmt>,
    /// What runs at every pixel.
    pub body: Vec<Stmt>,
    /// What gives `color` where the program assigns none but changes `normal`; run if a picture is wanted.
    pub by_normal: Option<Vec<Stmt>>,
    /// How many expressions are computed once a frame and kept.
    pub kept: usize,
    /// Does it ask for derivatives? Then each pixel runs with its shadows.
    pub derivatives: bool,
    /// Which statements of the body the shadows have to run too, if there are any.
    pub shadowed: Vec<bool>,
    /// The textures that calls name, each once, and where it is first named.
    pub textures: Vec<(texture::Source, Span)>,
    /// Tiles of those that are too large for memory.
    pub tiles: Arc<texture::Tiles>,
}

/// A variable of the outer level.
#[derive(Clone, Debug)]
pub struct Global {
    /// Its name; `bg.color` for a variable of a named image.
    pub name: String,
    /// Does a function of the library read it? Then it is never an input, nor what the program assigned.
    pub library: bool,
    /// Where the pixel's program first assigns it.
    pub assigned: Option<Span>,
    /// Where the frame's program first assigns it, or its `param` is.
    pub framed: Option<Span>,
    /// Where it is first read.
    pub read: Option<Span>,
}

impl Global {
    /// Does it hold one value for the frame, as far as the program goes? (An image may yet have a variable of
    /// that name.)
    pub fn is_frame(&self) -> bool {
        self.assigned.is_none() && (self.framed.is_some() || super::names::is_frame_constant(&self.name))
    }
}

/// A function of the language.
#[derive(Clone, Debug)]
pub struct Function {
    /// Its name.
    pub name: String,
    /// Where it is defined.
    pub span: Span,
    /// How many parameters it has; they are its first local slots.
    pub params: usize,
    /// The names of its local slots.
    pub locals: Vec<String>,
    /// Its block.
    pub body: Vec<Stmt>,
    /// The globals that it, or a function it calls, reads.
    pub reads: BTreeSet<u32>,
    /// Does it, or a function it calls, print?
    pub prints: bool,
}

/// A `param` declaration.
#[derive(Clone, Debug)]
pub struct Param {
    /// Its name.
    pub name: String,
    /// Its slot among the globals.
    pub slot: u32,
    /// Its default.
    pub value: Expr,
    /// `[low high]`.
    pub range: Option<Expr>,
    /// Where it is declared.
    pub span: Span,
}

/// Where a variable lives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Place {
    /// At the outer level.
    Global(u32),
    /// In the running call.
    Local(u32),
}

/// A statement.
#[derive(Clone, Debug)]
pub struct Stmt {
    /// What it does.
    pub kind: StmtKind,
    /// The place.
    pub span: Span,
}

/// Statements under a condition.
#[derive(Clone, Debug, Default)]
pub struct Block {
    /// In order.
    pub stmts: Vec<Stmt>,
    /// What they do together.
    pub effects: Arc<Effects>,
}

impl From<Vec<Stmt>> for Block {
    fn from(stmts: Vec<Stmt>) -> Block {
        Block { stmts, effects: Arc::default() }
    }
}

/// What statements do.
#[derive(Clone, Debug, Default)]
pub struct Effects {
    /// The variables that are read and not assigned.
    pub reads: Box<[Place]>,
    /// The variables that are assigned, all or some of their elements.
    pub writes: Box<[Place]>,
    /// Can a `break`, `continue` or `return` leave them for what is around them?
    pub leaves: bool,
    /// Does something in them print? Then they need to know which pixel each lane is.
    pub prints: bool,
    /// How much there is to compute for a pixel: 1 is about an operator on scalars.
    pub work: u32,
}

/// The kinds of statement.
#[derive(Clone, Debug)]
pub enum StmtKind {
    /// `x = e`, `x[i].y op= e`.
    Assign {
        /// The variable.
        place: Place,
        /// Its span.
        name: Span,
        /// The way to the element.
        path: Vec<Step>,
        /// The operator of `op=`.
        op: Option<BinaryOp>,
        /// The right-hand side.
        value: Expr,
    },
    /// An expression alone.
    Expr(Expr),
    /// Conditions with their blocks, and the `else` block.
    If(Vec<(Expr, Block)>, Block),
    /// A condition and its block, and what both together do.
    While(Expr, Vec<Stmt>, Arc<Effects>),
    /// The loop's variable, the vector, the block.
    For(Place, Expr, Vec<Stmt>),
    /// `break`
    Break,
    /// `continue`
    Continue,
    /// `return e`
    Return(Expr),
    /// `print("x", x)`
    Print(Vec<PrintPart>),
}

/// What `print` tells.
#[derive(Clone, Debug)]
pub enum PrintPart {
    /// A text, as it is.
    Text(String),
    /// A value.
    Value(Expr),
}

/// A step into a vector.
#[derive(Clone, Debug)]
pub enum Step {
    /// `[i]`
    Index(Expr),
    /// `.y` and the like: the component counted from 0, and its place.
    Component(u32, Span),
}

/// An expression.
#[derive(Clone, Debug)]
pub struct Expr {
    /// What it is.
    pub kind: ExprKind,
    /// The place.
    pub span: Span,
}

/// The kinds of expression.
#[derive(Clone, Debug)]
pub enum ExprKind {
    /// A number.
    Number(f32),
    /// A variable.
    Variable(Place),
    /// An expression that depends on constants, params and the frame alone: computed once and kept under
    /// this number, unless an image has a variable of a name that it reads.
    Kept(u32, Box<Expr>, Arc<[u32]>),
    /// `-e`, `!e`
    Unary(UnaryOp, Box<Expr>),
    /// `a op b`; `&&` and `||` compute `b` where they need it.
    Binary(BinaryOp, Box<Expr>, Box<Expr>),
    /// `c ? a : b`
    Conditional(Box<[Expr; 3]>),
    /// `[a b c]`
    Vector(Vec<Element>),
    /// `v[i]`
    Index(Box<Expr>, Box<Expr>),
    /// `v.y`: the component counted from 0.
    Component(Box<Expr>, u32),
    /// A call of a function of the language: its index and one argument a parameter.
    Call(u32, Vec<Expr>),
    /// A call of a built-in function.
    Builtin(&'static Builtin, Vec<Expr>),
    /// A call of a function that the embedding program gave.
    Host(Arc<HostFunction>, Vec<Expr>),
}

/// An element of a vector as it is written.
#[derive(Clone, Debug)]
pub enum Element {
    /// One.
    Item(Expr),
    /// `a .. b`: as many as there are.
    Range(Expr, Expr),
}

/// The expressions right inside of one.
pub(super) fn children(e: &mut Expr) -> Vec<&mut Expr> {
    match &mut e.kind {
        ExprKind::Number(_) | ExprKind::Variable(_) => Vec::new(),
        ExprKind::Kept(_, a, _) | ExprKind::Unary(_, a) | ExprKind::Component(a, _) => vec![a],
        ExprKind::Binary(_, a, b) | ExprKind::Index(a, b) => vec![a, b],
        ExprKind::Conditional(parts) => parts.iter_mut().collect(),
        ExprKind::Vector(elements) => elements
            .iter_mut()
            .flat_map(|element| match element {
                Element::Item(e) => vec![e],
                Element::Range(a, b) => vec![a, b],
            })
            .collect(),
        ExprKind::Call(_, args) | ExprKind::Builtin(_, args) | ExprKind::Host(_, args) => {
            args.iter_mut().collect()
        }
    }
}

impl Resolved {
    /// The names of the variables that the pixel's program assigns, in the order of their slots.
    pub fn assigned(&self) -> impl Iterator<Item = &str> {
        self.globals.iter().filter(|g| g.assigned.is_some() && !g.library).map(|g| g.name.as_str())
    }

    /// The slot of a variable of the program.
    pub fn slot(&self, name: &str) -> Option<u32> {
        self.globals.iter().position(|g| !g.library && g.name == name).map(|i| i as u32)
    }

    /// For each global: whether the pixel's program may see the value that it has at the beginning, be it that it reads it
    /// or that it assigns nothing on some way.
    pub fn exposed(&self) -> Vec<bool> {
        super::exposed::exposed(self)
    }
}
