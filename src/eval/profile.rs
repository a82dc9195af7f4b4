//! Where the time goes: what each statement took, without those inside of it.

use super::machine::Machine;
use crate::clock::Instant;
use crate::diagnostic::Span;
use crate::value::Mask;
use std::collections::HashMap;
use std::time::Duration;

/// What a statement took in all threads together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spent {
    /// Without the statements inside of it, or in functions that it calls.
    pub time: Duration,
    /// How often it was run for a batch.
    pub visits: u64,
    /// The lanes that were active, of all visits.
    pub active: u64,
    /// The lanes of the batches of all visits.
    pub lanes: u64,
}

impl Spent {
    /// Adds what another thread spent, or another statement.
    pub fn add(&mut self, other: &Spent) {
        self.time += other.time;
        self.visits += other.visits;
        self.active += other.active;
        self.lanes += other.lanes;
    }
}

/// What each statement took, by its place in the source.
pub type Profile = HashMap<Span, Spent>;

/// The clock of one thread.
pub struct Clock {
    spent: Profile,
    /// The statement that runs, and since when.
    at: Span,
    since: Instant,
}

impl Default for Clock {
    fn default() -> Clock {
        Clock { spent: Profile::new(), at: Span::default(), since: Instant::now() }
    }
}

impl Clock {
    /// Begins with a batch.
    pub fn start(&mut self) {
        self.since = Instant::now();
    }

    /// The time since the last look belongs to the statement that ran; now it is another's turn. Gives the former.
    pub fn turn(&mut self, to: Span) -> Span {
        let now = Instant::now();
        self.spent.entry(self.at).or_default().time += now - self.since;
        self.since = now;
        std::mem::replace(&mut self.at, to)
    }

    /// The time since the last look belongs to this statement.
    pub fn become_of(&mut self, statement: Span) {
        self.at = statement;
        self.turn(statement);
    }

    /// Notes that a statement is run.
    pub fn visit(&mut self, statement: Span, active: usize, lanes: usize) {
        let spent = self.spent.entry(statement).or_default();
        spent.visits += 1;
        spent.active += active as u64;
        spent.lanes += lanes as u64;
    }
}

impl Machine<'_> {
    /// Measures from now on.
    pub fn measure(&mut self) {
        self.clock = Some(Box::default());
        self.watched = true;
    }

    /// It is a statement's turn, in these lanes.
    pub(super) fn begin(&mut self, statement: Span, mask: &Mask) -> Span {
        let (n, width) = (self.n, self.width());
        let Some(clock) = &mut self.clock else { return statement };
        clock.visit(statement, mask.count(width), n);
        clock.turn(statement)
    }

    /// The statement is done; before it another ran.
    pub(super) fn done(&mut self, before: Span) {
        if let Some(clock) = &mut self.clock {
            clock.turn(before);
        }
    }

    /// What was measured.
    pub fn profile(&mut self) -> Profile {
        self.clock.take().map(|clock| clock.spent).unwrap_or_default()
    }
}
