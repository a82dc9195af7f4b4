//! What each name of a text stands for.

use crate::diagnostic::{SourceId, Span};
use crate::resolve::{Files, assigned, names};
use crate::syntax::ast::{Access, Expr, ExprKind, Function, Name, Stmt, StmtKind};
use std::collections::HashSet;
use std::ops::Range;

/// What a name stands for.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Symbol {
    /// A function, whoever defines it.
    Function(String),
    /// A variable of the outer level, or a name that every program can read.
    Outer(String),
    /// A parameter or another variable of a function.
    Local {
        /// The function.
        function: String,
        /// Its name there.
        name: String,
    },
}

impl Symbol {
    /// The name itself.
    pub fn name(&self) -> &str {
        match self {
            Symbol::Function(name) | Symbol::Outer(name) | Symbol::Local { name, .. } => name,
        }
    }

    /// The same kind of thing by another name.
    pub fn renamed(&self, name: &str) -> Symbol {
        let name = name.to_string();
        match self {
            Symbol::Function(_) => Symbol::Function(name),
            Symbol::Outer(_) => Symbol::Outer(name),
            Symbol::Local { function, .. } => Symbol::Local { function: function.clone(), name },
        }
    }
}

/// What a text does with a name at one place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// It is a function's name, its parameter, or a `param`.
    Define,
    /// It gets a value.
    Write,
    /// Its value is used.
    Read,
    /// It is called.
    Call,
    /// It names an argument of a call.
    Argument,
}

/// A name at a place.
#[derive(Clone, Debug, PartialEq)]
pub struct Occurrence {
    /// Its bytes.
    pub range: Range<usize>,
    /// What it stands for.
    pub symbol: Symbol,
    /// What is done with it.
    pub role: Role,
}

impl Occurrence {
    /// Its place in the program's own text.
    pub fn span(&self) -> Span {
        Span::new(SourceId::default(), self.range.start, self.range.end)
    }
}

/// A function's own names: its parameters and what its block assigns.
pub(super) fn locals(function: &Function) -> HashSet<&str> {
    let mut names: HashSet<&str> = function.params.iter().map(|(name, _)| name.text.as_str()).collect();
    assigned(&function.body, &mut |name| {
        names.insert(&name.text);
    });
    names
}

/// All of a program's own text, in order.
pub(super) fn of(files: &Files, text: &str) -> Vec<Occurrence> {
    let mut outer: HashSet<&str> = HashSet::new();
    assigned(&files.body, &mut |name| {
        outer.insert(&name.text);
    });
    let params = files.imported.iter().chain(&files.body).filter_map(|stmt| match &stmt.kind {
        StmtKind::Param { name, .. } => Some(name.text.as_str()),
        _ => None,
    });
    outer.extend(params);
    let mut walk = Walk { text, outer, function: None, list: Vec::new() };
    walk.block(&files.body);
    walk.list.sort_by_key(|o| o.range.start);
    walk.list
}

struct Walk<'a> {
    text: &'a str,
    /// The variables that the program gives a value.
    outer: HashSet<&'a str>,
    /// The function that is walked, and its own names.
    function: Option<(&'a str, HashSet<&'a str>)>,
    list: Vec<Occurrence>,
}

impl<'a> Walk<'a> {
    fn add(&mut self, span: Span, symbol: Symbol, role: Role) {
        let range = span.start as usize..span.end as usize;
        // What the parser made up to go on has another text.
        if self.text.get(range.clone()) == Some(symbol.name()) {
            self.list.push(Occurrence { range, symbol, role });
        }
    }

    /// What a variable's name stands for here.
    fn variable(&self, name: &str) -> Symbol {
        match &self.function {
            Some((function, locals)) if locals.contains(name) => {
                Symbol::Local { function: function.to_string(), name: name.to_string() }
            }
            _ => Symbol::Outer(name.to_string()),
        }
    }

    fn name(&mut self, name: &Name, role: Role) {
        self.add(name.span, self.variable(&name.text), role);
    }

    fn block(&mut self, block: &'a [Stmt]) {
        block.iter().for_each(|stmt| self.stmt(stmt));
    }

    fn stmt(&mut self, stmt: &'a Stmt) {
        match &stmt.kind {
            StmtKind::Assign { target, value, .. } => {
                self.name(&target.name, Role::Write);
                for step in &target.path {
                    if let Access::Index(e) = step {
                        self.expr(e);
                    }
                }
                self.expr(value);
            }
            StmtKind::Expr(e) | StmtKind::Return(e) => self.expr(e),
            StmtKind::If { arms, otherwise } => {
                for (condition, block) in arms {
                    self.expr(condition);
                    self.block(block);
                }
                otherwise.iter().for_each(|block| self.block(block));
            }
            StmtKind::While(condition, block) => {
                self.expr(condition);
                self.block(block);
            }
            StmtKind::For(name, vector, block) => {
                self.name(name, Role::Write);
                self.expr(vector);
                self.block(block);
            }
            StmtKind::Param { name, value, range } => {
                self.add(name.span, Symbol::Outer(name.text.clone()), Role::Define);
                self.expr(value);
                range.iter().for_each(|e| self.expr(e));
            }
            StmtKind::Function(f) => self.defined(f),
            StmtKind::Break | StmtKind::Continue | StmtKind::Import(..) => {}
        }
    }

    fn defined(&mut self, f: &'a Function) {
        self.add(f.name.span, Symbol::Function(f.name.text.clone()), Role::Define);
        // Defaults are computed where the call is, and see no names of the function.
        let outside = self.function.take();
        f.params.iter().filter_map(|(_, default)| default.as_ref()).for_each(|e| self.expr(e));
        self.function = Some((&f.name.text, locals(f)));
        f.params.iter().for_each(|(name, _)| self.name(name, Role::Define));
        self.block(&f.body);
        self.function = outside;
    }

    fn expr(&mut self, e: &'a Expr) {
        match &*e.kind {
            ExprKind::Number(_) | ExprKind::Text(_) | ExprKind::Error => {}
            ExprKind::Name(name) => self.add(e.span, self.variable(name), Role::Read),
            ExprKind::Member(base, member) => match &*base.kind {
                // A variable of a named image: `bg.color`.
                ExprKind::Name(image)
                    if names::component(&member.text).is_none()
                        && !self.outer.contains(image.as_str())
                        && matches!(self.variable(image), Symbol::Outer(_)) =>
                {
                    self.add(e.span, Symbol::Outer(format!("{image}.{}", member.text)), Role::Read);
                }
                _ => self.expr(base),
            },
            ExprKind::Call(name, arguments) => {
                self.add(name.span, Symbol::Function(name.text.clone()), Role::Call);
                for argument in arguments {
                    if let Some(given) = &argument.name {
                        let symbol = Symbol::Local { function: name.text.clone(), name: given.text.clone() };
                        self.add(given.span, symbol, Role::Argument);
                    }
                    self.expr(&argument.value);
                }
            }
            ExprKind::Unary(_, a) | ExprKind::Group(a) => self.expr(a),
            ExprKind::Index(a, b) | ExprKind::Binary(_, a, b) | ExprKind::Range(a, b) => {
                self.expr(a);
                self.expr(b);
            }
            ExprKind::Conditional(a, b, c) => [a, b, c].into_iter().for_each(|e| self.expr(e)),
            ExprKind::Vector(elements) => elements.iter().for_each(|e| self.expr(e)),
        }
    }
}
