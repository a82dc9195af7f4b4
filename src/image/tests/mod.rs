//! Tests of the whole: reading, binding, writing.
