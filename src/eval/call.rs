//! Calls: of the language's functions, of built-in ones, and of the host's.

use super::fault::{Fault, Result};
use super::host_function::HostFunction;
use super::machine::{Frame, Machine};
use crate::builtin::{self, Builtin};
use crate::diagnostic::{Diagnostic, Span};
use crate::host::HostError;
use crate::resolve::tree::*;
use crate::value::{Mask, PixelValue, Plane, Value};
use smallvec::SmallVec;

type Arguments = SmallVec<[Value; 4]>;

/// A value as a label shows it.
fn found(value: &Value, lane: usize) -> String {
    format!("{}: {}", value.shape, value.show(lane))
}

impl<'r> Machine<'r> {
    /// Computes arguments into `values`, where they stay: they are too large to be moved for nothing.
    fn arguments(&mut self, args: &'r [Expr], mask: &Mask, values: &mut Arguments) -> Result<()> {
        for arg in args {
            values.push(self.eval(arg, mask)?);
        }
        Ok(())
    }

    /// A call whose value is wanted.
    pub fn call(&mut self, f: u32, args: &'r [Expr], span: Span, mask: &Mask) -> Result<Value> {
        let (value, fell) = self.invoke(f, args, span, mask)?;
        match value {
            Some(value) if fell.is_none() => Ok(value),
            _ => {
                let function = &self.program.functions[f as usize];
                let message = format!("`{}()` ended without `return`", function.name);
                let error = Diagnostic::error("value", message, span)
                    .label(span, "its value is used here")
                    .label(function.span, "defined here")
                    .hint("End every path through the function with `return`.");
                let color = |g: &Global| g.name == "color" && g.assigned == Some(span);
                let error = if self.program.globals.iter().any(color) {
                    error.hint(
                        "It is the last expression of a program without `color`, so its value is the colour.",
                    )
                } else {
                    error
                };
                let lane = self.first(if fell.is_none() { mask } else { &fell });
                Err(self.fault(error, lane))
            }
        }
    }

    /// A call: what it returned, and the lanes that came to the end of its block without a return.
    pub fn invoke(
        &mut self,
        f: u32,
        args: &'r [Expr],
        span: Span,
        mask: &Mask,
    ) -> Result<(Option<Value>, Mask)> {
        let program = self.program;
        let function = &program.functions[f as usize];
        let mut values = Arguments::new();
        for arg in args {
            let depth = self.calls.len();
            let value = self.eval(arg, mask).map_err(|fault| match fault {
                Fault::Error(mut error, lane) if !span.holds(arg.span) => {
                    // A default, written with the function: who reads the message needs to see the call.
                    let outer = error.trace.len().saturating_sub(depth);
                    error.trace.insert(outer, (function.name.clone(), span));
                    Fault::Error(error, lane)
                }
                fault => fault,
            });
            values.push(value?);
        }
        self.step(mask, span)?;
        if self.calls.len() >= self.limits.depth as usize {
            let message = format!("calls are nested more than {} deep", self.limits.depth);
            let error = Diagnostic::error("limit", message, span)
                .hint(format!("Does the recursion of `{}()` end?", function.name))
                .hint("A higher limit can be set (`--max-depth`).");
            return Err(self.fault(error, self.first(mask)));
        }
        let traced = self.tracer.is_some().then(|| self.trace_call(f, span, &values));
        let base = self.enter(values, function.locals.len(), mask);
        let caller_base = std::mem::replace(&mut self.base, base);
        self.frames.push(Frame { returned: None, lanes: Mask::None, caller_base });
        self.calls.push((f, span));
        // A break inside of the function has nothing to do with the caller's loops; the resolver saw to that.
        let fell = self.block(&function.body, mask)?;
        self.calls.pop();
        self.locals.truncate(base);
        let Some(frame) = self.frames.pop() else { return Ok((None, fell)) };
        self.base = frame.caller_base;
        if let Some(event) = traced {
            self.trace_return(event, frame.returned.as_ref());
        }
        Ok((frame.returned, fell))
    }

    pub fn call_builtin(
        &mut self,
        builtin: &'static Builtin,
        args: &'r [Expr],
        span: Span,
        mask: &Mask,
    ) -> Result<Value> {
        let mut values = Arguments::new();
        self.arguments(args, mask, &mut values)?;
        let cells = values.iter().map(|v| v.planes.len()).sum();
        self.work(cells, values.iter().all(Value::is_uniform), mask, span)?;
        let call = builtin::Call {
            isa: self.isa,
            n: self.n,
            pixels: self.pixels(),
            mask,
            args: &values,
            max_cells: self.limits.cells,
            textures: &self.bound.textures,
        };
        let value = builtin
            .apply(&call)
            .map_err(|fault| self.builtin_fault(builtin, fault, &values, args, span, mask))?;
        if value.planes.len() > 4 {
            self.check_memory()?;
        }
        self.check_shape(&value.shape, span, mask)?;
        Ok(value)
    }

    fn builtin_fault(
        &self,
        builtin: &Builtin,
        fault: builtin::Fault,
        values: &[Value],
        args: &[Expr],
        span: Span,
        mask: &Mask,
    ) -> Fault {
        match fault {
            builtin::Fault::Split(lanes) => Fault::Split(lanes),
            builtin::Fault::Error { message, hint, arg, lane } => {
                let lane = lane.unwrap_or_else(|| self.first(mask));
                let place = arg.and_then(|i| args.get(i)).map_or(span, |e| e.span);
                let name = builtin.name;
                // Many kernels begin the sentence with the function's name.
                let message = match message.strip_prefix(name).filter(|rest| rest.starts_with(' ')) {
                    Some(rest) => format!("`{name}()`{rest}"),
                    None if ["meets ", "takes "].iter().any(|verb| message.starts_with(verb)) => {
                        format!("`{name}()` {message}")
                    }
                    None => format!("`{name}()`: {message}"),
                };
                let mut error = Diagnostic::error("call", message, place);
                for (i, (e, value)) in args.iter().zip(values).enumerate() {
                    // The reader needs to see all that met; defaults stand nowhere, and numbers for themselves.
                    let plain = matches!(e.kind, ExprKind::Number(_)) && arg != Some(i);
                    if e.span != span && !plain {
                        error = error.label(e.span, found(value, lane));
                    }
                }
                let usage = format!("It is called as `{}`.", builtin.signature());
                error = hint.into_iter().fold(error, Diagnostic::hint).hint(usage);
                self.fault(error, lane)
            }
        }
    }

    pub fn call_host(
        &mut self,
        host: &HostFunction,
        args: &'r [Expr],
        span: Span,
        mask: &Mask,
    ) -> Result<Value> {
        let mut values = Arguments::new();
        self.arguments(args, mask, &mut values)?;
        let failed = |machine: &Machine<'_>, why: HostError, lane: usize| {
            let mut error = Diagnostic::error("call", format!("`{}()`: {why}", host.name()), span);
            for (e, value) in args.iter().zip(&values).filter(|(e, _)| !matches!(e.kind, ExprKind::Number(_)))
            {
                error = error.label(e.span, found(value, lane));
            }
            machine.fault(error, lane)
        };
        if let Some(outcome) = host.call_batch(&values, self.n) {
            return outcome.map_err(|why| failed(self, why, self.first(mask)));
        }
        let n = self.n;
        let mut results: Vec<Option<PixelValue>> = vec![None; n];
        let mut first: Option<usize> = None;
        for lane in mask.lanes(n) {
            let pixel: Vec<PixelValue> = values.iter().map(|v| v.pixel(lane)).collect();
            let Some(outcome) = host.call_pixel(&pixel) else { break };
            // A shadow has its pixel's value where it would have none, or one of another shape.
            let pixel = if lane < self.pixels() { None } else { results[lane % self.pixels()].clone() };
            let value = match (outcome, pixel) {
                (Ok(value), Some(pixel)) if value.shape() != pixel.shape() => pixel,
                (Err(_), Some(pixel)) => pixel,
                (outcome, _) => outcome.map_err(|why| failed(self, why, lane))?,
            };
            first.get_or_insert(lane);
            results[lane] = Some(value);
        }
        let Some(shape) = first.and_then(|lane| results[lane].as_ref()).map(|v| v.shape().clone()) else {
            return Ok(Value::uniform(0.0));
        };
        let alike = |lane: usize| results[lane].as_ref().is_some_and(|v| *v.shape() == shape);
        if !mask.lanes(n).all(alike) {
            return Err(Fault::Split(Mask::from_fn(n, alike)));
        }
        let planes = (0..shape.cells())
            .map(|cell| {
                Plane::filled(n, |out| {
                    for (out, result) in out.iter_mut().zip(&results) {
                        *out = result.as_ref().map_or(0.0, |v| v.cells()[cell]);
                    }
                })
            })
            .collect();
        Ok(Value { shape, planes })
    }
}
