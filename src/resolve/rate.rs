//! What depends on the frame alone: found once here, computed once a frame by the evaluator.
//!
//! Perlin planned a compiler that "recognizes quantities that vary slowly over the image stream" (1985, "Now
//! What?"). An expression's *rate* is the fastest of what it reads: constants, params and the frame's variables
//! are slow, a pixel's variables fast. The largest slow expressions are wrapped in [`ExprKind::Kept`].

use super::tree::*;
use std::collections::BTreeSet;
use std::sync::Arc;

/// Adds to what each function reads what the functions it calls read, until nothing is added; and so with printing.
pub(super) fn close_reads(functions: &mut [Function], calls: &[BTreeSet<u32>]) {
    loop {
        let mut grew = false;
        for (caller, callees) in calls.iter().enumerate() {
            for &callee in callees {
                let add: Vec<u32> =
                    functions[callee as usize].reads.difference(&functions[caller].reads).copied().collect();
                let prints = functions[callee as usize].prints && !functions[caller].prints;
                grew |= !add.is_empty() || prints;
                functions[caller].reads.extend(add);
                functions[caller].prints |= prints;
            }
        }
        if !grew {
            return;
        }
    }
}

/// Wraps the largest expressions that depend on the frame alone.
pub(super) fn mark(program: &mut Resolved) {
    let reads: Vec<BTreeSet<u32>> = program.functions.iter().map(|f| f.reads.clone()).collect();
    let prints: Vec<bool> = program.functions.iter().map(|f| f.prints).collect();
    let frame: Vec<bool> = program.globals.iter().map(Global::is_frame).collect();
    let mut marker = Marker { reads, prints, frame, kept: 0 };
    let mut body = std::mem::take(&mut program.body);
    marker.block(&mut body);
    program.body = body;
    if let Some(block) = &mut program.by_normal {
        marker.block(block);
    }
    for function in &mut program.functions {
        marker.block(&mut function.body);
    }
    program.kept = marker.kept as usize;
}

struct Marker {
    reads: Vec<BTreeSet<u32>>,
    prints: Vec<bool>,
    frame: Vec<bool>,
    kept: u32,
}

/// The globals that a slow expression reads; `None` for a fast one.
type Slow = Option<BTreeSet<u32>>;

impl Marker {
    fn block(&mut self, block: &mut [Stmt]) {
        for stmt in block {
            match &mut stmt.kind {
                StmtKind::Assign { path, value, .. } => {
                    for step in path {
                        if let Step::Index(e) = step {
                            self.root(e);
                        }
                    }
                    self.root(value);
                }
                // A call whose value nobody wants may return none: there would be nothing to keep.
                StmtKind::Expr(e) if matches!(e.kind, ExprKind::Call(..)) => {
                    children(e).into_iter().for_each(|arg| self.root(arg));
                }
                StmtKind::Expr(e) | StmtKind::Return(e) => self.root(e),
                StmtKind::If(arms, otherwise) => {
                    for (condition, block) in arms {
                        self.root(condition);
                        self.block(&mut block.stmts);
                    }
                    self.block(&mut otherwise.stmts);
                }
                StmtKind::While(e, block, _) | StmtKind::For(_, e, block) => {
                    self.root(e);
                    self.block(block);
                }
                StmtKind::Print(parts) => {
                    for part in parts {
                        if let PrintPart::Value(e) = part {
                            self.root(e);
                        }
                    }
                }
                StmtKind::Break | StmtKind::Continue => {}
            }
        }
    }

    fn root(&mut self, e: &mut Expr) {
        let slow = self.rate(e);
        self.wrap(e, slow);
    }

    fn wrap(&mut self, e: &mut Expr, slow: Slow) {
        let leaf = matches!(e.kind, ExprKind::Number(_) | ExprKind::Variable(_));
        if let (Some(reads), false) = (slow, leaf) {
            let inner = Expr { kind: ExprKind::Number(0.0), span: e.span };
            let inner = std::mem::replace(e, inner);
            let reads: Arc<[u32]> = reads.into_iter().collect();
            e.kind = ExprKind::Kept(self.kept, Box::new(inner), reads);
            self.kept += 1;
        }
    }

    /// The rate of an expression; its slow parts are wrapped if it is fast itself.
    fn rate(&mut self, e: &mut Expr) -> Slow {
        let mut own = BTreeSet::new();
        let mut fast = false;
        match &e.kind {
            ExprKind::Variable(Place::Global(i)) if self.frame[*i as usize] => {
                own.insert(*i);
            }
            ExprKind::Variable(_) | ExprKind::Host(..) => fast = true,
            ExprKind::Call(f, _) => {
                own.extend(&self.reads[*f as usize]);
                // Each pixel prints, even if all print the same.
                fast = self.prints[*f as usize] || own.iter().any(|&i| !self.frame[i as usize]);
            }
            _ => {}
        }
        let rates: Vec<Slow> = children(e).into_iter().map(|child| self.rate(child)).collect();
        if !fast && rates.iter().all(Option::is_some) {
            own.extend(rates.into_iter().flatten().flatten());
            return Some(own);
        }
        for (child, slow) in children(e).into_iter().zip(rates) {
            self.wrap(child, slow);
        }
        None
    }
}
