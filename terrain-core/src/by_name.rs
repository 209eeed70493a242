//! Settings that are chosen by their names.

/// Writes and reads a type by the names of all its values: it has `ALL` and `name`, and the error holds the
/// name that none of them has.
macro_rules! by_name {
    ($choice:ident, $unknown:ident) => {
        impl std::fmt::Display for $choice {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.pad(self.name())
            }
        }

        impl std::str::FromStr for $choice {
            type Err = $unknown;

            fn from_str(name: &str) -> Result<Self, Self::Err> {
                let found = Self::ALL.into_iter().find(|choice| choice.name() == name);
                found.ok_or_else(|| $unknown(name.to_owned()))
            }
        }
    };
}

pub(crate) use by_name;
