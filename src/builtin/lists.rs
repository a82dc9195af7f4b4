//! Vectors as lists of elements: their number, sums, tests.

use super::call::{Call, Fault};
use super::{Builtin, Kernel, Lanes2, Param, ex};
use crate::lanes::{map1, map2};
use crate::value::{Plane, Value};

/// Combines the elements of the first argument from left to right; of none, it is `empty`; a scalar is itself.
fn reduce(call: &Call<'_>, empty: f32, kernel: Lanes2) -> Result<Value, Fault> {
    let v = &call.args[0];
    if v.shape.is_scalar() {
        return Ok(v.clone());
    }
    let mut elements = v.elements();
    let Some(first) = elements.next() else { return Ok(Value::uniform(empty)) };
    elements.try_fold(first, |value, next| call.cells2(&value, &next, kernel))
}

fn sum(call: &Call<'_>) -> Result<Value, Fault> {
    reduce(call, 0.0, |isa, a, b, out| map2(isa, a, b, out, |a, b| a + b))
}

fn product(call: &Call<'_>) -> Result<Value, Fault> {
    reduce(call, 1.0, |isa, a, b, out| map2(isa, a, b, out, |a, b| a * b))
}

fn mean(call: &Call<'_>) -> Result<Value, Fault> {
    let n = match call.args[0].shape.len() {
        None => return Ok(call.args[0].clone()),
        Some(0) => return Err(Fault::of(0, "mean of an empty vector has no value")),
        Some(n) => Value::uniform(n as f32),
    };
    call.cells2(&sum(call)?, &n, |isa, a, b, out| map2(isa, a, b, out, |a, b| a / b))
}

/// Is it so for one scalar at least, or for every one, at any depth?
fn test(call: &Call<'_>, of_none: f32, kernel: Lanes2) -> Value {
    let truth = |p: &Plane| call.map1(p, |isa, a, out| map1(isa, a, out, |x| f32::from(x != 0.0)));
    let start = Plane::Uniform(of_none);
    Value::scalar(call.args[0].planes.iter().map(truth).fold(start, |a, b| call.map2(&a, &b, kernel)))
}

fn all(call: &Call<'_>) -> Result<Value, Fault> {
    Ok(test(call, 1.0, |isa, a, b, out| map2(isa, a, b, out, |a, b| a * b)))
}

fn any(call: &Call<'_>) -> Result<Value, Fault> {
    Ok(test(call, 0.0, |isa, a, b, out| map2(isa, a, b, out, |a, b| if a > b { a } else { b })))
}

fn size(call: &Call<'_>) -> Result<Value, Fault> {
    match call.args[0].shape.len() {
        Some(n) => Ok(Value::uniform(n as f32)),
        None => Err(Fault::of(0, "size needs a vector, found a scalar")
            .hint("`abs()` gives the magnitude of a number.")),
    }
}

fn append(call: &Call<'_>) -> Result<Value, Fault> {
    let [v, rest @ ..] = call.args else { return Err(Fault::new("append needs a vector")) };
    if v.shape.is_scalar() {
        return Err(Fault::of(0, "append needs a vector to add to, found a scalar")
            .hint("`[ ]` makes a vector: `append([x], y)`."));
    }
    call.room(v.planes.len() + rest.iter().map(|r| r.planes.len()).sum::<usize>())?;
    Ok(Value::vector_of(v.elements().chain(rest.iter().cloned())))
}

fn reverse(call: &Call<'_>) -> Result<Value, Fault> {
    let v = &call.args[0];
    match v.shape.len() {
        None => Err(Fault::of(0, "reverse needs a vector, found a scalar")),
        Some(n) => Ok(Value::vector_of((0..n).rev().map(|i| v.element(i)))),
    }
}

/// Lists.
pub static FUNCTIONS: &[Builtin] = &[
    Builtin {
        name: "size",
        params: &[Param::new("v")],
        brief: "The number of elements of a vector.",
        doc: "At the outermost level: `size([[1 2] [3 4] [5 6]])` is 3. For the Euclidean length, see [norm](#norm).",
        examples: &[ex("size([5 6 7])", "3"), ex("size([[1 2] [3 4]])", "2"), ex("size([])", "0")],
        kernel: Kernel::Whole(size),
    },
    Builtin {
        name: "append",
        params: &[Param::new("v"), Param::rest("x", 1)],
        brief: "The vector with more elements at its end.",
        doc: "Each further argument becomes one element, even if it is a vector.",
        examples: &[ex("append([1 2], 3, 4)", "[1 2 3 4]"), ex("append([], [1 2])", "[[1 2]]")],
        kernel: Kernel::Whole(append),
    },
    Builtin {
        name: "reverse",
        params: &[Param::new("v")],
        brief: "The elements in the opposite order.",
        doc: "",
        examples: &[ex("reverse([1 2 3])", "[3 2 1]")],
        kernel: Kernel::Whole(reverse),
    },
    Builtin {
        name: "sum",
        params: &[Param::new("v")],
        brief: "The elements of a vector added up.",
        doc: "Adds from left to right; for a vector of vectors, component by component. The sum of an empty vector \
            is 0.",
        examples: &[ex("sum([1 2 3])", "6"), ex("sum([[1 2] [3 4]])", "[4 6]")],
        kernel: Kernel::Whole(sum),
    },
    Builtin {
        name: "product",
        params: &[Param::new("v")],
        brief: "The elements of a vector multiplied together.",
        doc: "Multiplies from left to right; for a vector of vectors, component by component. The product of an \
            empty vector is 1.",
        examples: &[ex("product([2 3 4])", "24")],
        kernel: Kernel::Whole(product),
    },
    Builtin {
        name: "mean",
        params: &[Param::new("v")],
        brief: "The average of the elements of a vector.",
        doc: "For a vector of vectors, component by component.",
        examples: &[ex("mean([1 2 6])", "3"), ex("mean([[0 0] [2 4]])", "[1 2]")],
        kernel: Kernel::Whole(mean),
    },
    Builtin {
        name: "all",
        params: &[Param::new("v")],
        brief: "1 if every component is true (not 0), else 0.",
        doc: "At any depth; of an empty vector, 1. A condition must be a scalar: `if all(color < 1)`.",
        examples: &[ex("all([1 2 0])", "0"), ex("all([1 2 3])", "1")],
        kernel: Kernel::Whole(all),
    },
    Builtin {
        name: "any",
        params: &[Param::new("v")],
        brief: "1 if at least one component is true (not 0), else 0.",
        doc: "At any depth; of an empty vector, 0. A condition must be a scalar: `if any(color > 1)`.",
        examples: &[ex("any([0 2 0])", "1"), ex("any([0 0])", "0")],
        kernel: Kernel::Whole(any),
    },
];
