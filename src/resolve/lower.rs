//! Statements, functions, params: from names to slots.

use super::HostFunctions;
use super::expr::MAX_LEVELS;
use super::names;
use super::scope::{Scope, assigned};
use super::tree::*;
use super::unknown::no_component;
use crate::diagnostic::{Diagnostic, Sources, Span};
use crate::host::Host;
use crate::stack::{self, Nesting};
use crate::syntax::{MAX_ERRORS, ast};
use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

/// How many errors get suggestions. Some of them may follow from errors of syntax and are not shown, so there are more of
/// these than of those that are.
const MAX_EXPLAINED: usize = 4 * MAX_ERRORS;

/// Turns the trees of a program's files into a [`Resolved`].
pub(super) struct Resolver<'a> {
    pub sources: &'a mut Sources,
    pub host: &'a dyn Host,
    pub hosts: &'a HostFunctions,
    pub errors: Vec<Diagnostic>,
    pub out: Resolved,
    /// Slots of the outer level, by whether they are the library's and by name.
    pub ids: HashMap<(bool, String), u32>,
    /// The program's functions: the tree, and the index once resolved.
    pub own: HashMap<String, (&'a ast::Function, u32)>,
    /// The library's functions that are called, by name.
    pub library: HashMap<&'static str, u32>,
    /// Which functions each function calls, for what it reads through them.
    pub calls: Vec<BTreeSet<u32>>,
    /// The function that is being resolved.
    pub current: Option<u32>,
    /// Calls in the frame's program: function, span; checked when all functions are known.
    pub framed_calls: Vec<(u32, Span)>,
    /// The strings that were given to name something, with their places.
    pub texts: Vec<(String, Span)>,
    /// The variable that has the value of the last outer expression, if it is not to be `color` alone.
    pub value: Option<&'a str>,
    /// Expressions and blocks inside of others.
    pub nesting: Nesting,
    /// The defaults that are being resolved, each for a call in the one before: function and parameter.
    pub defaults: Vec<(u32, usize)>,
    /// How many defaults were resolved for calls in defaults.
    pub inner_defaults: usize,
    /// The one function that is asked, if it is not the whole program that runs.
    pub entry: Option<&'a super::Entrance>,
}

impl<'a> Resolver<'a> {
    pub fn new(sources: &'a mut Sources, host: &'a dyn Host, hosts: &'a HostFunctions) -> Resolver<'a> {
        Resolver {
            sources,
            host,
            hosts,
            errors: Vec::new(),
            out: Resolved::default(),
            ids: HashMap::new(),
            own: HashMap::new(),
            library: HashMap::new(),
            calls: Vec::new(),
            current: None,
            framed_calls: Vec::new(),
            texts: Vec::new(),
            nesting: Nesting::default(),
            defaults: Vec::new(),
            inner_defaults: 0,
            value: None,
            entry: None,
        }
    }

    /// Whether an error that is found now may be shown. What is costly to find, such as the names that a misspelt one
    /// may mean, is looked for only then.
    pub fn is_shown(&self) -> bool {
        self.errors.len() < MAX_EXPLAINED
    }

    /// The name out of `known` that a misspelt one most likely means, if that will be shown.
    pub fn nearest<'k>(&self, name: &str, known: impl IntoIterator<Item = &'k str>) -> Option<&'k str> {
        if self.is_shown() { names::nearest(name, known) } else { None }
    }

    /// The whole program.
    pub fn program(&mut self, files: &'a super::import::Files) {
        let outer = || files.imported.iter().chain(&files.body);
        self.declare_functions(outer());
        self.declare_variables(&files.imported, &files.body);
        for stmt in outer() {
            if let ast::StmtKind::Param { name, value, range } = &stmt.kind {
                self.param(name, value, range.as_ref(), stmt.span);
            }
        }
        let own: Vec<_> = outer()
            .filter_map(|s| match &s.kind {
                ast::StmtKind::Function(f) => Some(f),
                _ => None,
            })
            .collect();
        for function in own {
            // A second definition of a name was reported, and has no index.
            if let Some((first, index)) = self.own.get(&function.name.text)
                && std::ptr::eq(*first, function)
            {
                let index = *index;
                self.function(function, index, false);
            }
        }
        self.outer_body(&files.body);
        self.implicit_color(&files.body);
    }

    /// Settles what functions read through other functions, and checks the frame's program against it.
    pub fn finish(&mut self) -> Resolved {
        super::rate::close_reads(&mut self.out.functions, &self.calls);
        self.check_framed_calls();
        super::rate::mark(&mut self.out);
        let seen = super::effects::mark(&mut self.out);
        if let Some(entry) = self.entry {
            self.errors.extend(super::entry::prune(&mut self.out, entry, &seen));
        }
        std::mem::take(&mut self.out)
    }

    /// The frame's program may only call functions that read nothing of a pixel.
    fn check_framed_calls(&mut self) {
        for (function, span) in std::mem::take(&mut self.framed_calls) {
            let reads = &self.out.functions[function as usize].reads;
            let pixel = reads
                .iter()
                .map(|&i| &self.out.globals[i as usize])
                .find(|g| !g.is_frame() && g.framed.is_none());
            if let Some(global) = pixel {
                let error = self.pixel_in_frame(&global.name, span, global.read, false);
                self.errors.push(error);
            }
        }
    }

    fn declare_functions(&mut self, outer: impl Iterator<Item = &'a ast::Stmt>) {
        for stmt in outer {
            let ast::StmtKind::Function(function) = &stmt.kind else { continue };
            let name = &function.name;
            if let Some((first, _)) = self.own.get(&name.text) {
                let first = first.name.span;
                let message = format!("the function `{}()` is defined twice", name.text);
                let error = Diagnostic::error("name", message, name.span)
                    .label(name.span, "again here")
                    .label(first, "first here")
                    .hint("Give one of them another name.");
                self.errors.push(error);
                continue;
            }
            let index = self.reserve(&name.text, name.span);
            self.own.insert(name.text.clone(), (function, index));
        }
    }

    /// An index for a function whose block is resolved later.
    pub fn reserve(&mut self, name: &str, span: Span) -> u32 {
        self.out.functions.push(Function {
            name: name.into(),
            span,
            params: 0,
            locals: Vec::new(),
            body: Vec::new(),
            reads: BTreeSet::new(),
            prints: false,
        });
        self.calls.push(BTreeSet::new());
        self.out.functions.len() as u32 - 1
    }

    /// Notes which outer variables are the frame's and which the pixel's, before anything reads them.
    fn declare_variables(&mut self, imported: &[ast::Stmt], body: &[ast::Stmt]) {
        for stmt in imported.iter().chain(body) {
            match &stmt.kind {
                ast::StmtKind::Param { name, .. } => {
                    let slot = self.global(&name.text, false);
                    if let Some(first) = self.out.globals[slot as usize].framed {
                        let message = format!("the param `{}` is declared twice", name.text);
                        let error = Diagnostic::error("name", message, name.span)
                            .label(name.span, "again here")
                            .label(first, "first here")
                            .hint("Give one of them another name.");
                        self.errors.push(error);
                    }
                    self.out.globals[slot as usize].framed = Some(name.span);
                }
                _ => {
                    let (frame, rest) = split_frame(stmt);
                    let mut note = |name: &ast::Name, framed: bool| {
                        let slot = self.global(&name.text, false) as usize;
                        let global = &mut self.out.globals[slot];
                        let place = if framed { &mut global.framed } else { &mut global.assigned };
                        place.get_or_insert(name.span);
                    };
                    frame.iter().for_each(|block| assigned(block, &mut |name| note(name, true)));
                    match rest {
                        Rest::All => assigned(std::slice::from_ref(stmt), &mut |name| note(name, false)),
                        Rest::Arms(arms, otherwise) => {
                            arms.iter().for_each(|(_, b)| assigned(b, &mut |name| note(name, false)));
                            otherwise.iter().for_each(|b| assigned(b, &mut |name| note(name, false)));
                        }
                    }
                }
            }
        }
    }

    fn param(&mut self, name: &ast::Name, value: &ast::Expr, range: Option<&ast::Expr>, span: Span) {
        let mut scope = Scope { frame: true, param: true, ..Scope::default() };
        let value = self.expr(value, &mut scope);
        let range = range.map(|range| self.expr(range, &mut scope));
        let slot = self.global(&name.text, false);
        if let Some(assigned) = self.out.globals[slot as usize].assigned {
            let error = Diagnostic::error("name", format!("the param `{}` is assigned", name.text), assigned)
                .label(assigned, "assigned here")
                .label(name.span, "declared here")
                .hint("A param is set from outside. To change it, copy it to a variable of another name.");
            self.errors.push(error);
        }
        self.out.params.push(Param { name: name.text.clone(), slot, value, range, span });
    }

    fn outer_body(&mut self, body: &[ast::Stmt]) {
        for stmt in body {
            let (frame, rest) = split_frame(stmt);
            if let Some(block) = frame {
                let mut scope = Scope { frame: true, blocks: 1, ..Scope::default() };
                let block = self.block(block, &mut scope);
                self.out.frame.extend(block);
            }
            let mut scope = Scope::default();
            match rest {
                Rest::All => {
                    let stmt = self.stmt(stmt, &mut scope);
                    self.out.body.extend(stmt);
                }
                // `else if` and `else` of `if begin_frame` belong to the pixels.
                Rest::Arms([], None) => {}
                Rest::Arms([], Some(otherwise)) => {
                    let block = self.block(otherwise, &mut scope);
                    self.out.body.extend(block);
                }
                Rest::Arms(arms, otherwise) => {
                    scope.blocks = 1;
                    let kind = self.branches(arms, otherwise, &mut scope);
                    self.out.body.push(Stmt { kind, span: stmt.span });
                }
            }
        }
    }

    /// If nothing assigns `color`, or another variable is to have it: the last outer expression is it; without one, a changed `normal` gives it.
    fn implicit_color(&mut self, body: &[ast::Stmt]) {
        let assigns = |r: &Resolver, name: &str| {
            r.ids
                .get(&(false, name.to_string()))
                .is_some_and(|&i| r.out.globals[i as usize].assigned.is_some())
        };
        if assigns(self, "color") && self.value.is_none() {
            return;
        }
        let valued =
            |s: &&ast::Stmt| matches!(&s.kind, ast::StmtKind::Expr(e) if self.print_arguments(e).is_none());
        let last = body.iter().rfind(valued);
        if let Some(last) = last {
            let index = self
                .out
                .body
                .iter()
                .rposition(|s| s.span == last.span && matches!(s.kind, StmtKind::Expr(_)));
            if let Some(index) = index {
                let slot = self.global(self.value.unwrap_or("color"), false);
                self.out.globals[slot as usize].assigned = Some(last.span);
                let stmt = &mut self.out.body[index];
                if let StmtKind::Expr(value) = &stmt.kind {
                    let (value, name) = (value.clone(), stmt.span);
                    let place = Place::Global(slot);
                    stmt.kind = StmtKind::Assign { place, name, path: Vec::new(), op: None, value };
                }
            }
        } else if assigns(self, "normal") && !assigns(self, "color") {
            let id = self.sources.add("<picture by the normal>", "color = shown_by_normal(normal)");
            let parsed = crate::syntax::parse(id, &self.sources.get(id).text.clone());
            let slot = self.global("color", false);
            let block = self.block(&parsed.module.body, &mut Scope::default());
            self.out.by_normal = Some(block);
            // The program itself assigns no colour: who lists its outputs must not find one.
            self.out.globals[slot as usize].assigned = None;
        }
    }

    /// A function's block, into the place reserved for it.
    pub fn function(&mut self, function: &ast::Function, index: u32, library: bool) {
        let mut locals: HashMap<String, u32> = HashMap::new();
        let mut names: Vec<String> = Vec::new();
        for (name, _) in &function.params {
            if locals.insert(name.text.clone(), names.len() as u32).is_some() {
                let message = format!("`{}()` has two parameters called `{}`", function.name.text, name.text);
                let error = Diagnostic::error("name", message, name.span)
                    .label(name.span, "again here")
                    .hint("Give one of them another name.");
                let first = function.params.iter().find(|(n, _)| n.text == name.text);
                self.errors.push(match first {
                    Some((first, _)) => error.label(first.span, "first here"),
                    None => error,
                });
            }
            names.push(name.text.clone());
        }
        assigned(&function.body, &mut |name| {
            if !locals.contains_key(&name.text) {
                locals.insert(name.text.clone(), names.len() as u32);
                names.push(name.text.clone());
            }
        });
        let outer = self.current.replace(index);
        let mut scope = Scope { locals: Some(locals), library, ..Scope::default() };
        let body = self.block(&function.body, &mut scope);
        self.current = outer;
        let resolved = &mut self.out.functions[index as usize];
        resolved.params = function.params.len();
        resolved.locals = names;
        resolved.body = body;
    }

    pub fn block(&mut self, body: &[ast::Stmt], scope: &mut Scope) -> Vec<Stmt> {
        body.iter().filter_map(|stmt| self.stmt(stmt, scope)).collect()
    }

    fn nested(&mut self, body: &[ast::Stmt], scope: &mut Scope) -> Vec<Stmt> {
        if stack::is_low() {
            return stack::grow(|| self.nested(body, scope));
        }
        let Some(first) = body.first() else { return Vec::new() };
        if !self.nesting.enter(MAX_LEVELS) {
            self.too_deep(first.span);
            return Vec::new();
        }
        scope.blocks += 1;
        let block = self.block(body, scope);
        scope.blocks -= 1;
        self.nesting.leave();
        block
    }

    fn looped(&mut self, body: &[ast::Stmt], scope: &mut Scope) -> Vec<Stmt> {
        scope.loops += 1;
        let block = self.nested(body, scope);
        scope.loops -= 1;
        block
    }

    fn branches(
        &mut self,
        arms: &[(ast::Expr, Vec<ast::Stmt>)],
        otherwise: Option<&Vec<ast::Stmt>>,
        scope: &mut Scope,
    ) -> StmtKind {
        let arms = arms.iter().map(|(c, b)| (self.expr(c, scope), self.nested(b, scope).into())).collect();
        StmtKind::If(arms, otherwise.map_or(Vec::new(), |b| self.nested(b, scope)).into())
    }

    fn stmt(&mut self, stmt: &ast::Stmt, scope: &mut Scope) -> Option<Stmt> {
        use ast::StmtKind as Written;
        let misplaced = |what: &str| Diagnostic::error("place", what, stmt.span);
        let nested = scope.blocks > 0 || scope.locals.is_some();
        let kind = match &stmt.kind {
            Written::Assign { target, op, value } => {
                // The value first: `x = x + 1` reads before it stores.
                let value = self.expr(value, scope);
                let written = &target.name.text;
                let path = target.path.iter().filter_map(|step| self.step(step, written, scope)).collect();
                let place = self.target(&target.name, scope);
                StmtKind::Assign { place, name: target.name.span, path, op: *op, value }
            }
            Written::Expr(e) => match self.print_arguments(e) {
                Some(args) => self.print(args, scope),
                None => StmtKind::Expr(self.expr(e, scope)),
            },
            Written::If { arms, otherwise } => self.branches(arms, otherwise.as_ref(), scope),
            Written::While(condition, body) => {
                let condition = self.expr(condition, scope);
                StmtKind::While(condition, self.looped(body, scope), Arc::default())
            }
            Written::For(name, vector, body) => {
                let vector = self.expr(vector, scope);
                let place = self.target(name, scope);
                StmtKind::For(place, vector, self.looped(body, scope))
            }
            Written::Break | Written::Continue if scope.loops == 0 => {
                let (what, does) = match stmt.kind {
                    Written::Break => ("break", "leaves"),
                    _ => ("continue", "continues with the next iteration of"),
                };
                let error = misplaced(&format!("`{what}` is outside of a loop"))
                    .hint(format!("It {does} the enclosing `while` or `for`. Put it inside a loop."));
                self.errors.push(error);
                return None;
            }
            Written::Break => StmtKind::Break,
            Written::Continue => StmtKind::Continue,
            Written::Return(value) => {
                let value = self.expr(value, scope);
                if scope.locals.is_none() {
                    let error = misplaced("`return` is outside of a function")
                        .hint("Outside of functions, assign the result to `color`.");
                    self.errors.push(error);
                    return None;
                }
                StmtKind::Return(value)
            }
            Written::Function(f) => {
                if nested {
                    let error = misplaced("a function is defined inside a block").hint(format!(
                        "Move `{}()` to the left margin, before or after the lines that call it.",
                        f.name.text
                    ));
                    self.errors.push(error);
                }
                return None;
            }
            Written::Param { name, .. } => {
                if nested {
                    let error = misplaced("a param is declared inside a block")
                        .hint(format!("Move the declaration of `{}` to the left margin.", name.text));
                    self.errors.push(error);
                    // That is said, so nobody needs to hear that the name has no value.
                    let slot = self.global(&name.text, false);
                    self.out.globals[slot as usize].framed.get_or_insert(name.span);
                }
                return None;
            }
            Written::Import(..) => {
                self.errors.push(misplaced("`import` is inside a block").hint("Move it to the left margin."));
                return None;
            }
        };
        Some(Stmt { kind, span: stmt.span })
    }

    fn step(&mut self, step: &ast::Access, written: &str, scope: &mut Scope) -> Option<Step> {
        match step {
            ast::Access::Index(e) => Some(Step::Index(self.expr(e, scope))),
            ast::Access::Member(name) => match names::component(&name.text) {
                Some(i) => Some(Step::Component(i, name.span)),
                None => {
                    self.errors.push(no_component(written, &name.text, name.span));
                    None
                }
            },
        }
    }

    /// Where an assignment to a name goes.
    fn target(&mut self, name: &ast::Name, scope: &Scope) -> Place {
        match scope.locals.as_ref().and_then(|l| l.get(&name.text)) {
            Some(&slot) => Place::Local(slot),
            None => Place::Global(self.global(&name.text, scope.library)),
        }
    }

    /// The slot of an outer variable.
    pub fn global(&mut self, name: &str, library: bool) -> u32 {
        *self.ids.entry((library, name.to_string())).or_insert_with(|| {
            let name = name.to_string();
            self.out.globals.push(Global { name, library, assigned: None, framed: None, read: None });
            self.out.globals.len() as u32 - 1
        })
    }
}

/// What of a statement is left when the block of `if begin_frame` is taken out.
enum Rest<'a> {
    /// All: it is no `if begin_frame`.
    All,
    /// The other branches.
    Arms(&'a [(ast::Expr, Vec<ast::Stmt>)], Option<&'a Vec<ast::Stmt>>),
}

/// The block of `if begin_frame`, if that is what the statement is, and the rest of it.
fn split_frame(stmt: &ast::Stmt) -> (Option<&[ast::Stmt]>, Rest<'_>) {
    fn is_begin_frame(e: &ast::Expr) -> bool {
        match &*e.kind {
            ast::ExprKind::Name(name) => name == "begin_frame",
            ast::ExprKind::Group(inner) => is_begin_frame(inner),
            _ => false,
        }
    }
    match &stmt.kind {
        ast::StmtKind::If { arms, otherwise } if arms.first().is_some_and(|(c, _)| is_begin_frame(c)) => {
            (Some(&arms[0].1), Rest::Arms(&arms[1..], otherwise.as_ref()))
        }
        _ => (None, Rest::All),
    }
}
