//! The tree of a program as it was written: names are still names, every node has its span.

use crate::diagnostic::Span;

/// A name with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Name {
    /// The text.
    pub text: String,
    /// The place.
    pub span: Span,
}

/// A whole file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Module {
    /// The statements at the outer level, in order.
    pub body: Vec<Stmt>,
}

/// A statement with its span (for a block statement, of its header line only).
#[derive(Clone, Debug, PartialEq)]
pub struct Stmt {
    /// What it does.
    pub kind: StmtKind,
    /// The place.
    pub span: Span,
}

/// The kinds of statement.
#[derive(Clone, Debug, PartialEq)]
pub enum StmtKind {
    /// `target = value`, or `target op= value` with the operator.
    Assign {
        /// What is assigned to.
        target: Target,
        /// The operator of `op=`, with the whole token's span; `None` for `=`.
        op: Option<BinaryOp>,
        /// The right-hand side.
        value: Expr,
    },
    /// An expression alone.
    Expr(Expr),
    /// `if` / `else if` / `else`.
    If {
        /// Conditions and their blocks, in order: the `if` and every `else if`.
        arms: Vec<(Expr, Vec<Stmt>)>,
        /// The `else` block.
        otherwise: Option<Vec<Stmt>>,
    },
    /// `while condition` and its block.
    While(Expr, Vec<Stmt>),
    /// `for name in vector` and its block.
    For(Name, Expr, Vec<Stmt>),
    /// `break`.
    Break,
    /// `continue`.
    Continue,
    /// `return value`.
    Return(Expr),
    /// `function name(params)` and its block.
    Function(Function),
    /// `param name = value in [low high]`.
    Param {
        /// The frame variable it makes.
        name: Name,
        /// Its default.
        value: Expr,
        /// `[low high]`, the slider's range.
        range: Option<Expr>,
    },
    /// `import "file.pse"`: the path and the string's span.
    Import(String, Span),
}

/// A function's definition.
#[derive(Clone, Debug, PartialEq)]
pub struct Function {
    /// Its name.
    pub name: Name,
    /// Its parameters, with defaults.
    pub params: Vec<(Name, Option<Expr>)>,
    /// Its block.
    pub body: Vec<Stmt>,
}

/// What an assignment stores to: a variable, followed by any number of `[i]` and `.x`.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    /// The variable.
    pub name: Name,
    /// The places inside it, outermost first.
    pub path: Vec<Access>,
    /// All of it.
    pub span: Span,
}

/// One step into a vector.
#[derive(Clone, Debug, PartialEq)]
pub enum Access {
    /// `[i]`.
    Index(Expr),
    /// `.x`.
    Member(Name),
}

/// An expression with its span.
#[derive(Clone, Debug, PartialEq)]
pub struct Expr {
    /// What it is.
    pub kind: Box<ExprKind>,
    /// The place.
    pub span: Span,
}

/// The kinds of expression.
#[derive(Clone, Debug, PartialEq)]
pub enum ExprKind {
    /// A number. The formatter prints its source text, so that `1e-3` stays `1e-3`.
    Number(f32),
    /// A string, without its quotes and with its escapes undone.
    Text(String),
    /// A variable or constant.
    Name(String),
    /// `e.name`: a component, or a variable of the image `e`.
    Member(Expr, Name),
    /// `e[i]`.
    Index(Expr, Expr),
    /// `f(args)`.
    Call(Name, Vec<Argument>),
    /// `-e`, `!e`.
    Unary(UnaryOp, Expr),
    /// `a op b`.
    Binary(BinaryOp, Expr, Expr),
    /// `condition ? then : otherwise`.
    Conditional(Expr, Expr, Expr),
    /// `[a b c]`.
    Vector(Vec<Expr>),
    /// `a .. b`, only as an element of a vector: a, a+1, … up to b.
    Range(Expr, Expr),
    /// `(e)`: kept, so that the formatter keeps the brackets that a reader wanted.
    Group(Expr),
    /// What could not be read. The error is already in the list; nothing after the parser sees one.
    Error,
}

/// An argument of a call, by position or by name.
#[derive(Clone, Debug, PartialEq)]
pub struct Argument {
    /// `name =`, if it is given by name.
    pub name: Option<Name>,
    /// Its value.
    pub value: Expr,
}

/// An operator before its operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum UnaryOp {
    /// `-`
    Neg,
    /// `!`
    Not,
}

/// An operator between two operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)] // the names say it
pub enum BinaryOp {
    Add,
    Sub,
    Mul,
    Div,
    Rem,
    Pow,
    Eq,
    Ne,
    Lt,
    Le,
    Gt,
    Ge,
    And,
    Or,
}

impl BinaryOp {
    /// As it is written.
    pub fn symbol(self) -> &'static str {
        use BinaryOp::*;
        match self {
            Add => "+",
            Sub => "-",
            Mul => "*",
            Div => "/",
            Rem => "%",
            Pow => "^",
            Eq => "==",
            Ne => "!=",
            Lt => "<",
            Le => "<=",
            Gt => ">",
            Ge => ">=",
            And => "&&",
            Or => "||",
        }
    }
}

impl UnaryOp {
    /// As it is written.
    pub fn symbol(self) -> &'static str {
        match self {
            UnaryOp::Neg => "-",
            UnaryOp::Not => "!",
        }
    }
}
