//! Calls: which function a name means, and which argument goes to which parameter.

use super::lower::Resolver;
use super::scope::Scope;
use super::tree::{Expr, ExprKind};
use super::{library, names, print};
use crate::builtin::{self, Builtin, Kernel, ParamKind};
use crate::diagnostic::{Diagnostic, Span};
use crate::syntax::{self, MAX_ERRORS, ast};
use crate::vocabulary;

/// Defaults that may be resolved for calls in other defaults. Each call has its own, so a few functions could ask for
/// any number of them.
const MAX_INNER_DEFAULTS: usize = 10_000;

/// What a call's arguments are matched with.
struct Signature {
    /// The function's name.
    name: String,
    /// As a call is written, for messages.
    text: String,
    /// In order.
    params: Vec<Parameter>,
    /// If the last one takes any number: at least so many.
    rest: Option<usize>,
}

/// A parameter as a call sees it.
struct Parameter {
    name: String,
    /// May it be left out?
    optional: bool,
    /// The strings that it takes, if it does: one of these, or any if there are none.
    choice: Option<&'static [&'static str]>,
}

impl Parameter {
    fn value(name: &str, optional: bool) -> Parameter {
        Parameter { name: name.into(), optional, choice: None }
    }
}

impl Signature {
    fn usage(&self) -> String {
        format!("It is called as `{}`.", self.text)
    }
}

impl Resolver<'_> {
    /// Is there a function of that name?
    pub fn is_function(&self, name: &str) -> bool {
        self.own.contains_key(name)
            || self.hosts.contains_key(name)
            || library::find(name).is_some()
            || builtin::find(name).is_some()
            || name == print::NAME
    }

    pub fn call(&mut self, name: &ast::Name, args: &[ast::Argument], span: Span, scope: &mut Scope) -> Expr {
        let kind = if let Some(&(function, index)) = self.own.get(&name.text).filter(|_| !scope.library) {
            self.call_function(function, index, false, args, span, scope)
        } else if let Some(host) = self.hosts.get(&name.text).filter(|_| !scope.library).cloned() {
            let signature = Signature {
                name: name.text.clone(),
                text: host.signature(),
                params: host.params().iter().map(|p| Parameter::value(p, false)).collect(),
                rest: None,
            };
            self.arguments(&signature, args, span, scope)
                .map(|args| ExprKind::Host(host, args.into_iter().flatten().flatten().collect()))
        } else if let Some(entry) = library::find(&name.text) {
            let index = match self.library.get(entry.name.as_str()) {
                Some(&index) => index,
                None => {
                    let source = library::source(self.sources, entry);
                    let function = library::function(entry, source);
                    let index = self.reserve(&function.name.text, function.name.span);
                    self.library.insert(&entry.name, index);
                    self.function(&function, index, true);
                    index
                }
            };
            let source = library::source(self.sources, entry);
            let function = library::function(entry, source);
            self.call_function(&function, index, true, args, span, scope)
        } else if let Some(builtin) = builtin::find(&name.text) {
            if let Some(call) = self.space_call(builtin, args, span, scope) {
                return call;
            }
            self.call_builtin(builtin, args, span, scope)
        } else if name.text == print::NAME {
            self.no_print(args, span, scope)
        } else {
            // A string is no mistake of its own: some function may take one.
            for arg in args.iter().filter(|arg| !matches!(&*arg.value.kind, ast::ExprKind::Text(_))) {
                self.expr(&arg.value, scope);
            }
            let error = self.unknown_function(name, args.len(), scope);
            // It looks through the whole text: not for more errors than are reported.
            let error = match self.errors.len() < MAX_ERRORS {
                true => super::unknown::about_includes(&self.sources.get(name.span.source).text, error),
                false => error,
            };
            self.errors.push(error);
            None
        };
        // After an error any value will do: the program does not run.
        Expr { kind: kind.unwrap_or(ExprKind::Number(0.0)), span }
    }

    fn unknown_function(&self, name: &ast::Name, arguments: usize, scope: &Scope) -> Diagnostic {
        let error = |message: String| Diagnostic::error("name", message, name.span);
        let written = &name.text;
        let local = scope.locals.as_ref().is_some_and(|l| l.contains_key(written));
        let variable = local
            || names::constant(written).is_some()
            || names::is_system(written)
            || names::USUAL_INPUTS.contains(&written.as_str())
            || self.is_assigned(written);
        if variable {
            let error = error(format!("`{written}` is a variable, not a function"));
            return error.hint(match constructor(written).filter(|_| arguments > 1) {
                Some(instead) => instead.to_string(),
                None => format!(
                    "To multiply, write `{written} * (…)`; to take an element of a vector, `{written}[1]`."
                ),
            });
        }
        let error = error(format!("there is no function `{written}()`"));
        if !self.is_shown() {
            return error;
        }
        let own = self.own.keys().chain(self.hosts.keys()).map(String::as_str);
        let ours = library::entries()
            .map(|e| e.name.as_str())
            .chain(builtin::all().map(|b| b.name))
            .chain([print::NAME]);
        let here = vocabulary::function(written);
        let near = match here {
            // A word that is known from elsewhere is no slip of a word that is known here.
            Some(_) => names::nearest(written, own),
            None => names::nearest(written, own.chain(ours)),
        };
        match (near, here) {
            (None, None) => {
                error.hint(format!("To define it, write `function {written}(…)` and its block below."))
            }
            _ => {
                let near = near.map(|near| format!("Did you mean `{near}()`?"));
                near.into_iter().chain(here.map(String::from)).fold(error, Diagnostic::hint)
            }
        }
    }

    fn signature(&self, function: &ast::Function) -> String {
        syntax::signature(function, &self.sources.get(function.name.span.source).text)
    }

    fn call_function(
        &mut self,
        function: &ast::Function,
        index: u32,
        library: bool,
        args: &[ast::Argument],
        span: Span,
        scope: &mut Scope,
    ) -> Option<ExprKind> {
        if let Some(current) = self.current {
            self.calls[current as usize].insert(index);
        }
        if scope.frame {
            self.framed_calls.push((index, span));
        }
        let params =
            function.params.iter().map(|(name, default)| Parameter::value(&name.text, default.is_some()));
        let signature = Signature {
            name: function.name.text.clone(),
            text: self.signature(function),
            params: params.collect(),
            rest: None,
        };
        let given = self.arguments(&signature, args, span, scope)?;
        let mut outer = Scope { library, frame: scope.frame, ..Scope::default() };
        let mut args = Vec::new();
        for (number, (given, (param, default))) in given.into_iter().zip(&function.params).enumerate() {
            args.extend(match (given.and_then(|mut values| values.pop()), default) {
                (Some(given), _) => Some(given),
                (None, Some(default)) if self.begin_default((index, number), &param.text, span) => {
                    let default = self.expr(default, &mut outer);
                    self.defaults.pop();
                    Some(default)
                }
                (None, Some(default)) => Some(Expr { kind: ExprKind::Number(0.0), span: default.span }),
                (None, None) => None,
            });
        }
        Some(ExprKind::Call(index, args))
    }

    /// Whether a default can be resolved for a call; if so, it is noted as being resolved.
    fn begin_default(&mut self, default: (u32, usize), param: &str, call: Span) -> bool {
        const CODE: &str = "default";
        self.inner_defaults += usize::from(!self.defaults.is_empty());
        let error = if self.defaults.contains(&default) {
            let message = format!("the default of `{param}` needs itself: this call leaves out `{param}`");
            Diagnostic::error(CODE, message, call).hint(format!("Give `{param}` in this call."))
        } else if self.inner_defaults > MAX_INNER_DEFAULTS {
            let message = format!(
                "calls in the defaults of parameters have more than {MAX_INNER_DEFAULTS} defaults themselves"
            );
            Diagnostic::error(CODE, message, call).hint(format!("Give `{param}` in this call."))
        } else {
            self.defaults.push(default);
            return true;
        };
        // It may come up again for each call of the function.
        let is_reported = |other: &Diagnostic| {
            other.code == CODE
                && (other.labels.first().is_some_and(|label| label.span == call)
                    || other.message == error.message)
        };
        if !self.errors.iter().any(is_reported) {
            self.errors.push(error);
        }
        false
    }

    fn call_builtin(
        &mut self,
        builtin: &'static Builtin,
        args: &[ast::Argument],
        span: Span,
        scope: &mut Scope,
    ) -> Option<ExprKind> {
        let rest = builtin.params.iter().find_map(|p| match p.kind {
            ParamKind::Rest(least) => Some(least),
            _ => None,
        });
        let params = builtin.params.iter().map(|p| match p.kind {
            ParamKind::Choice(of) => Parameter { name: p.name.into(), optional: true, choice: Some(of) },
            ParamKind::Text => {
                Parameter { name: p.name.into(), optional: p.default.is_some(), choice: Some(&[]) }
            }
            _ => Parameter::value(p.name, p.default.is_some()),
        });
        let signature = Signature {
            name: builtin.name.into(),
            text: builtin.signature(),
            params: params.collect(),
            rest,
        };
        let given = self.arguments(&signature, args, span, scope)?;
        let mut args = Vec::new();
        for (given, param) in given.into_iter().zip(builtin.params) {
            match (given, param.default) {
                (Some(values), _) => args.extend(values),
                (None, Some(_)) if param.kind == ParamKind::Text => {
                    args.push(Expr { kind: ExprKind::Number(f32::NAN), span });
                }
                (None, Some(text)) => args.push(self.default(text, span, scope)),
                // The first of its strings is a choice's default.
                (None, None) => args.push(Expr { kind: ExprKind::Number(0.0), span }),
            }
        }
        self.out.derivatives |= matches!(builtin.kernel, Kernel::Shadowed(_));
        self.texture(builtin, &mut args)?;
        Some(ExprKind::Builtin(builtin, args))
    }

    /// A built-in parameter's default, an expression of the language, as if it stood in the call.
    fn default(&mut self, text: &str, span: Span, scope: &Scope) -> Expr {
        let mut parsed = syntax::parse_expression(span.source, text);
        if let Some(e) = &mut parsed {
            syntax::set_span(e, span);
        }
        let mut outer = Scope { library: true, frame: scope.frame, ..Scope::default() };
        match parsed {
            Some(e) => self.expr(&e, &mut outer),
            None => Expr { kind: ExprKind::Number(0.0), span },
        }
    }

    /// Matches arguments with parameters: for each the values given, `None` where its default is to be used. A
    /// string becomes its number among those that the parameter takes, or if it takes any, among the texts.
    fn arguments(
        &mut self,
        signature: &Signature,
        args: &[ast::Argument],
        span: Span,
        scope: &mut Scope,
    ) -> Option<Vec<Option<Vec<Expr>>>> {
        let before = self.errors.len();
        let mut given: Vec<Option<Vec<Expr>>> = signature.params.iter().map(|_| None).collect();
        let last = signature.params.len().wrapping_sub(1);
        let mut position = 0;
        let mut extra: Vec<Span> = Vec::new();
        for arg in args {
            let index = match &arg.name {
                None => {
                    position += 1;
                    let index = position - 1;
                    if signature.rest.is_some() { index.min(last) } else { index }
                }
                Some(name) => match signature.params.iter().position(|p| p.name == name.text) {
                    Some(index) => index,
                    None => {
                        self.expr(&arg.value, scope);
                        let error = self.unknown_parameter(signature, name);
                        self.errors.push(error);
                        continue;
                    }
                },
            };
            let Some(param) = signature.params.get(index) else {
                self.expr(&arg.value, scope);
                extra.push(arg.value.span);
                continue;
            };
            let Some(value) = self.argument(signature, param, &arg.value, scope) else { continue };
            match &mut given[index] {
                Some(values) if signature.rest.is_some() && index == last => values.push(value),
                Some(_) => {
                    let error = Diagnostic::error(
                        "arity",
                        format!("`{}` is given twice", param.name),
                        arg.value.span,
                    )
                    .label(arg.value.span, "a second value for it")
                    .hint(signature.usage());
                    self.errors.push(error);
                }
                slot => *slot = Some(vec![value]),
            }
        }
        let name = &signature.name;
        if let (Some(first), Some(end)) = (extra.first(), extra.last()) {
            let n = signature.params.len();
            let most = if signature.params.iter().any(|p| p.optional) { "at most " } else { "" };
            let s = if n == 1 { "" } else { "s" };
            let message = format!("`{name}()` takes {most}{n} argument{s}, found {}", args.len());
            let error = Diagnostic::error("arity", message, first.to(*end))
                .label(first.to(*end), if extra.len() == 1 { "one too many" } else { "too many" })
                .hint(signature.usage());
            self.errors.push(error);
        }
        if self.errors.len() > before {
            return None;
        }
        let missing = signature.params.iter().zip(&given).enumerate().filter(|(i, (param, values))| {
            let count = values.as_ref().map_or(0, Vec::len);
            match signature.rest {
                Some(least) if *i == last => count < least,
                _ => count == 0 && !param.optional,
            }
        });
        let missing: Vec<String> = missing.map(|(_, (param, _))| format!("`{}`", param.name)).collect();
        if missing.is_empty() {
            return Some(given);
        }
        let message = match signature.rest {
            Some(least) => {
                format!("`{name}()` takes at least {} arguments, found {}", last + least, args.len())
            }
            None => format!("`{name}()` is called without {}", missing.join(", ")),
        };
        self.errors.push(Diagnostic::error("arity", message, span).hint(signature.usage()));
        None
    }

    /// The value of an argument for a parameter; `None` after an error.
    fn argument(
        &mut self,
        signature: &Signature,
        param: &Parameter,
        value: &ast::Expr,
        scope: &mut Scope,
    ) -> Option<Expr> {
        let name = &signature.name;
        let error = |message: String| Diagnostic::error("string", message, value.span);
        let (error, written) = match (&*value.kind, param.choice) {
            (_, None) if !matches!(&*value.kind, ast::ExprKind::Text(_)) => {
                return Some(self.expr(value, scope));
            }
            (ast::ExprKind::Text(text), Some([])) => {
                self.texts.push((text.clone(), value.span));
                let number = self.texts.len() - 1;
                return Some(Expr { kind: ExprKind::Number(number as f32), span: value.span });
            }
            (_, Some([])) => {
                let error = error(format!("`{name}()` takes a string for `{}`", param.name));
                let written = self.sources.text(value.span);
                let word = |c: char| c.is_alphanumeric() || "._".contains(c);
                let error = match written.chars().all(word) {
                    true => error.hint(format!("Write it in quotes: \"{written}\".")),
                    false => error,
                };
                self.errors.push(error.hint(signature.usage()));
                return None;
            }
            (ast::ExprKind::Text(text), Some(of)) => match of.iter().position(|c| c == text) {
                Some(choice) => {
                    return Some(Expr { kind: ExprKind::Number(choice as f32), span: value.span });
                }
                None => (error(format!("`{name}()` has no {} \"{text}\"", param.name)), text.as_str()),
            },
            (ast::ExprKind::Name(text), Some(_)) => {
                (error(format!("`{name}()` takes a string for `{}`", param.name)), text.as_str())
            }
            (_, Some(_)) => (error(format!("`{name}()` takes a string for `{}`", param.name)), ""),
            (_, None) => {
                let error = error(format!("`{name}()` does not take a string for `{}`", param.name));
                // A compositor's matte is that of an object; the function of that name is a surface without gloss.
                let object = vocabulary::function("cryptomatte").filter(|_| name == "matte");
                let error = object.into_iter().fold(error, Diagnostic::hint);
                self.errors.push(error.hint(signature.usage()));
                return None;
            }
        };
        let of = param.choice.unwrap_or_default();
        let error = match of
            .iter()
            .copied()
            .find(|c| *c == written)
            .or_else(|| self.nearest(written, of.iter().copied()))
        {
            Some(near) if near == written => error.hint(format!("Write it in quotes: \"{near}\".")),
            Some(near) => error.hint(format!("Did you mean \"{near}\"?")),
            None => error,
        };
        let list: Vec<String> = of.iter().map(|c| format!("\"{c}\"")).collect();
        self.errors.push(error.hint(format!("Use one of {}.", list.join(", "))));
        None
    }

    fn unknown_parameter(&self, signature: &Signature, name: &ast::Name) -> Diagnostic {
        let message = format!("`{}()` has no parameter `{}`", signature.name, name.text);
        let error = Diagnostic::error("arity", message, name.span);
        let error = match self.nearest(&name.text, signature.params.iter().map(|p| p.name.as_str())) {
            Some(near) => error.hint(format!("Did you mean `{near}`?")),
            None => error,
        };
        error.hint(signature.usage())
    }
}

/// What to write instead of a variable's name that makes a vector in shading languages: `color(1, 0, 0)`.
fn constructor(name: &str) -> Option<&'static str> {
    let is = matches!(name, "color" | "point" | "normal" | "motion");
    vocabulary::function("vec3").filter(|_| is)
}
