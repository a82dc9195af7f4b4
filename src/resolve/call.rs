//! Calls: which function a name means, and which argument goes to which parameter.

use super::lower::Resolver;
use super::scope::Scope;
use super::tree::{Expr, ExprKind};
use super::{library, names};
use crate::builtin::{self, Builtin, ParamKind};
use crate::diagnostic::{Diagnostic, Span};
use crate::syntax::{self, ast};

/// What a call's arguments are matched with.
struct Signature {
    /// As it is written, for messages.
    text: String,
    /// Names in order, and whether each may be left out.
    params: Vec<(String, bool)>,
    /// If the last one takes any number: at least so many.
    rest: Option<usize>,
}

impl Resolver<'_> {
    /// Is there a function of that name?
    pub fn is_function(&self, name: &str) -> bool {
        self.own.contains_key(name)
            || self.hosts.contains_key(name)
            || library::find(name).is_some()
            || builtin::find(name).is_some()
    }

    pub fn call(&mut self, name: &ast::Name, args: &[ast::Argument], span: Span, scope: &mut Scope) -> Expr {
        let kind = if let Some(&(function, index)) = self.own.get(&name.text).filter(|_| !scope.library) {
            self.call_function(function, index, false, args, span, scope)
        } else if let Some(host) = self.hosts.get(&name.text).filter(|_| !scope.library).cloned() {
            let signature = Signature {
                text: host.signature(),
                params: host.params().iter().map(|p| (p.clone(), false)).collect(),
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
            self.call_builtin(builtin, args, span, scope)
        } else {
            for arg in args {
                self.expr(&arg.value, scope);
            }
            let error = self.unknown_function(name, scope);
            self.errors.push(error);
            None
        };
        // After an error any value will do: the program does not run.
        Expr { kind: kind.unwrap_or(ExprKind::Number(0.0)), span }
    }

    fn unknown_function(&self, name: &ast::Name, scope: &Scope) -> Diagnostic {
        let error = |message: String| Diagnostic::error("name", message, name.span);
        let local = scope.locals.as_ref().is_some_and(|l| l.contains_key(&name.text));
        let variable = local
            || names::constant(&name.text).is_some()
            || self
                .out
                .globals
                .iter()
                .any(|g| g.name == name.text && (g.assigned.is_some() || g.framed.is_some()));
        if variable {
            return error(format!("{} is a variable, no function", name.text))
                .hint(format!("To take an element of a vector write {}[1].", name.text));
        }
        let error = error(format!("there is no function {}()", name.text));
        let known = self
            .own
            .keys()
            .chain(self.hosts.keys())
            .map(String::as_str)
            .chain(library::entries().map(|e| e.name.as_str()))
            .chain(builtin::all().map(|b| b.name));
        match names::nearest(&name.text, known) {
            Some(near) => error.hint(format!("Did you mean {near}()?")),
            None => error.hint("pse doc lists the built-in functions; function name(a, b) defines one."),
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
        let params: Vec<(String, bool)> =
            function.params.iter().map(|(name, default)| (name.text.clone(), default.is_some())).collect();
        let signature = Signature { text: self.signature(function), params, rest: None };
        let given = self.arguments(&signature, args, span, scope)?;
        let mut outer = Scope { library, frame: scope.frame, ..Scope::default() };
        let args = given.into_iter().zip(&function.params).filter_map(|(given, (_, default))| {
            let given = given.and_then(|mut values| values.pop());
            given.or_else(|| default.as_ref().map(|default| self.expr(default, &mut outer)))
        });
        let args = args.collect();
        Some(ExprKind::Call(index, args))
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
        let optional = |p: &builtin::Param| p.default.is_some() || matches!(p.kind, ParamKind::Choice(_));
        let params = builtin.params.iter().map(|p| (p.name.to_string(), optional(p))).collect();
        let signature = Signature { text: builtin.signature(), params, rest };
        // Strings are taken out first: they are no values.
        let mut choices = Vec::new();
        let mut values: Vec<ast::Argument> = Vec::new();
        for (position, arg) in args.iter().enumerate() {
            match &*arg.value.kind {
                ast::ExprKind::Text(text) => choices.push((position, arg, text)),
                _ => values.push(arg.clone()),
            }
        }
        let mut chosen: Vec<(usize, f32)> = Vec::new();
        for (position, arg, text) in choices {
            let named = match &arg.name {
                Some(name) => builtin.params.iter().position(|p| p.name == name.text),
                None => Some(position).filter(|&i| i < builtin.params.len()),
            };
            let error = |message: String| Diagnostic::error("string", message, arg.value.span);
            match named.map(|i| (i, builtin.params[i].kind)) {
                Some((i, ParamKind::Choice(of))) => match of.iter().position(|c| c == text) {
                    Some(choice) => chosen.push((i, choice as f32)),
                    None => {
                        let param = builtin.params[i].name;
                        let mut error = error(format!("{}() knows no {param} \"{text}\"", builtin.name));
                        if let Some(near) = names::nearest(text, of.iter().copied()) {
                            error = error.hint(format!("Did you mean \"{near}\"?"));
                        }
                        let list: Vec<String> = of.iter().map(|c| format!("\"{c}\"")).collect();
                        self.errors.push(error.hint(format!("It knows {}.", list.join(", "))));
                        return None;
                    }
                },
                _ => {
                    let message = format!("{}() takes no string here", builtin.name);
                    self.errors.push(error(message).hint(format!("It is called as {}.", signature.text)));
                    return None;
                }
            }
        }
        let given = self.arguments(&signature, &values, span, scope)?;
        let mut args = Vec::new();
        for (i, (given, param)) in given.into_iter().zip(builtin.params).enumerate() {
            match (param.kind, given) {
                (ParamKind::Choice(_), None) => {
                    let choice = chosen.iter().find(|(at, _)| *at == i).map_or(0.0, |(_, choice)| *choice);
                    args.push(Expr { kind: ExprKind::Number(choice), span });
                }
                (ParamKind::Choice(_), Some(values)) => {
                    let span = values.first().map_or(span, |v| v.span);
                    let message = format!("{}() wants a string for {}", builtin.name, param.name);
                    let error = Diagnostic::error("string", message, span)
                        .hint(format!("It is called as {}.", signature.text));
                    self.errors.push(error);
                    return None;
                }
                (_, Some(values)) => args.extend(values),
                (_, None) => {
                    if let Some(text) = param.default {
                        args.push(self.default(text, span, scope));
                    }
                }
            }
        }
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

    /// Matches arguments with parameters: for each the values given, `None` where its default is to be used.
    fn arguments(
        &mut self,
        signature: &Signature,
        args: &[ast::Argument],
        span: Span,
        scope: &mut Scope,
    ) -> Option<Vec<Option<Vec<Expr>>>> {
        let mut given: Vec<Option<Vec<Expr>>> = signature.params.iter().map(|_| None).collect();
        let mut ok = true;
        let last = signature.params.len().wrapping_sub(1);
        let usage = format!("It is called as {}.", signature.text);
        let mut position = 0;
        let mut extra = Vec::new();
        for arg in args {
            let value = self.expr(&arg.value, scope);
            let index = match &arg.name {
                None => {
                    position += 1;
                    let index = position - 1;
                    if signature.rest.is_some() { index.min(last) } else { index }
                }
                Some(name) => match signature.params.iter().position(|(p, _)| *p == name.text) {
                    Some(index) => index,
                    None => {
                        let params = signature.params.iter().map(|(p, _)| p.as_str());
                        let near = names::nearest(&name.text, params).map(|n| format!("Did you mean {n}?"));
                        let message = format!("there is no parameter called {}", name.text);
                        let error = Diagnostic::error("arity", message, name.span)
                            .hint(near.unwrap_or(usage.clone()));
                        self.errors.push(error);
                        ok = false;
                        continue;
                    }
                },
            };
            match given.get_mut(index) {
                None => extra.push(value.span),
                Some(Some(values)) if signature.rest.is_some() && index == last => values.push(value),
                Some(Some(_)) => {
                    let message = format!("{} is given twice", signature.params[index].0);
                    self.errors.push(Diagnostic::error("arity", message, arg.value.span).hint(usage.clone()));
                    ok = false;
                }
                Some(slot) => *slot = Some(vec![value]),
            }
        }
        let name = signature.text.split('(').next().unwrap_or_default();
        if let (Some(first), Some(end)) = (extra.first(), extra.last()) {
            let n = signature.params.len();
            let s = if n == 1 { "" } else { "s" };
            let message = format!("{name}() takes {n} argument{s}, found {}", args.len());
            let error = Diagnostic::error("arity", message, first.to(*end))
                .label(first.to(*end), if extra.len() == 1 { "one too many" } else { "too many" })
                .hint(usage.clone());
            self.errors.push(error);
            ok = false;
        }
        let missing: Vec<&str> = signature
            .params
            .iter()
            .zip(&given)
            .enumerate()
            .filter(|(i, ((_, optional), values))| {
                let count = values.as_ref().map_or(0, Vec::len);
                match signature.rest {
                    Some(least) if *i == last => count < least,
                    _ => count == 0 && !optional,
                }
            })
            .map(|(_, ((name, _), _))| name.as_str())
            .collect();
        if ok && !missing.is_empty() {
            let message = match signature.rest {
                Some(least) if missing.contains(&signature.params[last].0.as_str()) && least > 1 => {
                    format!("{name}() wants at least {} arguments, found {}", last + least, args.len())
                }
                _ => format!("{name}() is called without {}", missing.join(", ")),
            };
            self.errors.push(Diagnostic::error("arity", message, span).hint(usage));
            ok = false;
        }
        ok.then_some(given)
    }
}
