//! Another name for something, everywhere.

use super::{Reading, Role, Symbol};
use crate::host::Host;
use crate::reference;
use crate::syntax;
use std::ops::Range;

impl Reading {
    /// Can this be given another name, as far as this text can tell? If not: why, as a sentence.
    pub fn may_rename(&self, symbol: &Symbol) -> Result<(), String> {
        let name = symbol.name();
        if self.faulty {
            return Err("The program has mistakes. Correct them first.".into());
        }
        match symbol {
            Symbol::Outer(_) if is_standard(name) && self.param(name).is_none() => {
                Err(format!("`{name}` is the name of a variable of images, so it cannot be renamed."))
            }
            Symbol::Outer(_) if self.definition(symbol).is_none() => {
                Err(format!("`{name}` comes from the image: the program does not define it."))
            }
            Symbol::Function(function) | Symbol::Local { function, .. }
                if self.own_function(function).is_none() =>
            {
                Err(match self.function(function) {
                    Some(_) => {
                        format!("`{function}()` is part of the language, so its names cannot be changed.")
                    }
                    None => format!("There is no function `{function}()`."),
                })
            }
            _ => Ok(()),
        }
    }

    /// Is it known to who imports this text: a function, its parameter or a param?
    pub fn is_shared(&self, symbol: &Symbol) -> bool {
        match symbol {
            Symbol::Function(_) => true,
            Symbol::Outer(name) => self.param(name).is_some(),
            Symbol::Local { function, name } => self
                .own_function(function)
                .is_some_and(|f| f.params.iter().any(|(param, _)| param.text == *name)),
        }
    }

    /// The places in this text that a new name has to be written to.
    ///
    /// # Errors
    /// If the name cannot be had: why, as a sentence.
    pub fn rename(
        &self,
        symbol: &Symbol,
        new: &str,
        name: &str,
        host: &dyn Host,
    ) -> Result<Vec<Range<usize>>, String> {
        syntax::check_name(new)?;
        let renamed = symbol.renamed(new);
        let outer = matches!(symbol, Symbol::Outer(_));
        if outer && is_standard(new) {
            return Err(format!("`{new}` is the name of a variable of images."));
        }
        let places: Vec<Range<usize>> = self.places(symbol).map(|(place, _)| place).collect();
        let mut text = self.text().to_string();
        for place in places.iter().rev() {
            text.replace_range(place.clone(), new);
        }
        // The text as it will be must mean the same, name by name.
        let after = Reading::new(name, &text, host);
        let moved = |old: &Symbol| match old {
            old if old == symbol => renamed.clone(),
            Symbol::Local { function, name } if *symbol == Symbol::Function(function.clone()) => {
                Symbol::Local { function: new.to_string(), name: name.clone() }
            }
            old => old.clone(),
        };
        let alike = self.occurrences.len() == after.occurrences.len()
            && self
                .occurrences
                .iter()
                .zip(&after.occurrences)
                .all(|(old, new)| moved(&old.symbol) == new.symbol);
        let taken = self.occurrences.iter().any(|o| o.symbol == renamed)
            || (matches!(symbol, Symbol::Function(_)) && self.own_function(new).is_some())
            || (outer && self.param(new).is_some());
        match taken || !alike {
            true => Err(format!("`{new}` is the name of something else here.")),
            false => Ok(places),
        }
    }

    /// Every place of a symbol in this text, with what is done there.
    pub fn places<'a>(&'a self, symbol: &'a Symbol) -> impl Iterator<Item = (Range<usize>, Role)> + 'a {
        self.occurrences.iter().filter(move |o| o.symbol == *symbol).map(|o| (o.range.clone(), o.role))
    }
}

/// Is it a constant, or something that the system or an image gives?
fn is_standard(name: &str) -> bool {
    reference::names().iter().any(|(_, lines)| lines.iter().any(|line| line.0 == name))
}
