//! Every scene, seen from outside.
