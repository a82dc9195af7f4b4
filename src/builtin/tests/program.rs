//! Just enough of the language to run the examples of the table: numbers, vectors, operators, calls, indices.

use super::super::{Call, Fault, ParamKind, find};
use crate::lanes::{Isa, map2};
use crate::value::{Mask, Plane, Value, binary};

/// How an expression is run.
pub struct Run<'a> {
    pub isa: Isa,
    pub n: usize,
    /// The value of the k-th number written, counted from 0.
    pub literal: &'a dyn Fn(usize, f32) -> Value,
}

struct Reader<'a> {
    run: &'a Run<'a>,
    text: &'a [u8],
    at: usize,
    literals: usize,
    in_vector: bool,
}

/// The value of an expression.
pub fn run(run: &Run<'_>, code: &str) -> Result<Value, Fault> {
    let mut reader = Reader { run, text: code.as_bytes(), at: 0, literals: 0, in_vector: false };
    let value = reader.binary(0)?;
    reader.blanks();
    assert_eq!(reader.at, code.len(), "cannot read {code}");
    Ok(value)
}

/// The value of an expression for one pixel.
pub fn value(code: &str) -> Result<Value, Fault> {
    run(&Run { isa: Isa::detect(), n: 1, literal: &|_, x| Value::uniform(x) }, code)
}

/// The message of the fault that an expression has.
pub fn message(code: &str) -> String {
    match value(code) {
        Err(Fault::Error { message, .. }) => message,
        other => panic!("{code} gave {other:?}"),
    }
}

const LEVELS: [&[&str]; 4] = [&["&&"], &[">=", "<"], &["+", "-"], &["*", "/"]];

fn operator(name: &str, a: f32, b: f32) -> f32 {
    match name {
        "+" => a + b,
        "-" => a - b,
        "*" => a * b,
        "/" => a / b,
        ">=" => f32::from(a >= b),
        "<" => f32::from(a < b),
        _ => f32::from(a != 0.0 && b != 0.0),
    }
}

impl Reader<'_> {
    fn blanks(&mut self) {
        while self.text.get(self.at) == Some(&b' ') {
            self.at += 1;
        }
    }

    fn eat(&mut self, what: &str) -> bool {
        let found = self.text[self.at..].starts_with(what.as_bytes());
        self.at += if found { what.len() } else { 0 };
        found
    }

    fn binary(&mut self, level: usize) -> Result<Value, Fault> {
        let Some(operators) = LEVELS.get(level) else { return self.unary() };
        let mut value = self.binary(level + 1)?;
        'next: loop {
            let start = self.at;
            self.blanks();
            let spaced = self.at > start;
            for name in *operators {
                if self.eat(name) {
                    if self.in_vector && spaced && self.text[self.at] != b' ' {
                        break;
                    }
                    self.blanks();
                    let right = self.binary(level + 1)?;
                    value = binary(&value, &right, |a, b| {
                        super::super::call::map2(self.run.isa, self.run.n, a, b, |isa, a, b, out| {
                            map2(isa, a, b, out, |a, b| operator(name, a, b))
                        })
                    })
                    .expect("shapes that meet");
                    continue 'next;
                }
            }
            self.at = start;
            return Ok(value);
        }
    }

    fn unary(&mut self) -> Result<Value, Fault> {
        if self.eat("-") {
            let value = self.unary()?;
            return Ok(crate::value::map1(&value, |p| match p {
                Plane::Uniform(x) => Plane::Uniform(-x),
                Plane::Varying(l) => Plane::filled(self.run.n, |out| {
                    out.iter_mut().zip(l.get(self.run.n)).for_each(|(o, x)| *o = -x);
                }),
            }));
        }
        let mut value = self.primary()?;
        while self.eat("[") {
            let index = self.binary(0)?;
            assert!(self.eat("]"));
            value = value.element(index.planes[0].lane(0).round() as usize - 1);
        }
        Ok(value)
    }

    fn primary(&mut self) -> Result<Value, Fault> {
        self.blanks();
        if self.eat("[") {
            let outer = std::mem::replace(&mut self.in_vector, true);
            let mut elements = Vec::new();
            self.blanks();
            while !self.eat("]") {
                elements.push(self.binary(0)?);
                self.blanks();
            }
            self.in_vector = outer;
            return Ok(Value::vector_of(elements));
        }
        let start = self.at;
        while self.text.get(self.at).is_some_and(|c| c.is_ascii_alphanumeric() || *c == b'_' || *c == b'.') {
            self.at += 1;
        }
        let word = std::str::from_utf8(&self.text[start..self.at]).unwrap().to_string();
        assert!(!word.is_empty(), "nothing at {start} of {}", String::from_utf8_lossy(self.text));
        if word == "pi" {
            return Ok(Value::uniform(std::f32::consts::PI));
        }
        if word == "pixelsize" {
            return Ok(Value::uniform(0.01));
        }
        if let Ok(number) = word.parse::<f32>() {
            self.literals += 1;
            return Ok((self.run.literal)(self.literals - 1, number));
        }
        assert!(self.eat("("), "{word} is no number");
        let outer = std::mem::replace(&mut self.in_vector, false);
        let value = self.call(&word);
        self.in_vector = outer;
        value
    }

    fn call(&mut self, name: &str) -> Result<Value, Fault> {
        let builtin = find(name).unwrap_or_else(|| panic!("no function {name}"));
        let mut args: Vec<Option<Value>> = vec![None; builtin.params.len()];
        let mut rest = Vec::new();
        let mut position = 0;
        while !self.eat(")") {
            self.blanks();
            let named = builtin.params.iter().position(|p| self.eat(&format!("{} = ", p.name)));
            let to = named.unwrap_or(position);
            position += 1;
            if self.eat("\"") {
                let end = self.at + self.text[self.at..].iter().position(|c| *c == b'"').unwrap();
                let word = std::str::from_utf8(&self.text[self.at..end]).unwrap();
                let ParamKind::Choice(of) = builtin.params[to].kind else { panic!("{name} takes no string") };
                let chosen = of.iter().position(|c| *c == word).unwrap();
                args[to] = Some(Value::uniform(chosen as f32));
                self.at = end + 1;
            } else {
                let value = self.binary(0)?;
                match builtin.params.get(to).map(|p| p.kind) {
                    Some(ParamKind::Value) => args[to] = Some(value),
                    _ => rest.push(value),
                }
            }
            self.eat(",");
            self.blanks();
        }
        let mut all = Vec::new();
        for (param, arg) in builtin.params.iter().zip(args) {
            match (arg, param.kind, param.default) {
                (Some(arg), _, _) => all.push(arg),
                (None, ParamKind::Choice(_), _) => all.push(Value::uniform(0.0)),
                (None, ParamKind::Value, Some(code)) => all.push(value(code)?),
                (None, ParamKind::Rest(least), _) => assert!(rest.len() >= least, "{name} takes {least}"),
                (None, ParamKind::Value, None) => panic!("{name} needs {}", param.name),
            }
        }
        all.append(&mut rest);
        let (isa, n) = (self.run.isa, self.run.n);
        builtin.apply(&Call { isa, n, mask: &Mask::All, args: &all, max_cells: 1000 })
    }
}
