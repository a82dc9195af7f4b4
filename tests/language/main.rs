//! The language and its engine: programs and what comes of them, messages, documentation.

mod batches;
mod derivatives;
mod docs;
mod editors;
mod embedding;
mod errors;
mod host;
mod paper;
mod patterns;
mod programs;
mod reference;
mod samples;
mod trace;
