//! Commands as lines of CSV.

use super::{Burst, Command};
use std::fmt;
use std::io::{self, BufRead};

/// The first line of a file of commands.
///
/// A command is a line. Its `command` is ACT, RD, WR, PRE or REF; numbers are decimal; a field that the
/// command does not have is empty, and RD and WR may leave out `row`. `bank` is `all` for REF, and for PRE
/// of all banks.
pub const HEADER: &str = "clock,command,bank,row,column,beats";

/// How many characters of a wrong field an error shows.
const SHOWN: usize = 40;

/// What is wrong with a file of commands, and where.
#[derive(Debug, thiserror::Error)]
pub enum CsvError {
    /// The line cannot be read, or is no text.
    #[error("line {line}: {error}")]
    Read {
        /// The line, from 1.
        line: u64,
        /// Why.
        error: io::Error,
    },
    /// The file does not begin with the header.
    #[error("line 1: `{found}` is not `{HEADER}`")]
    Header {
        /// The line.
        found: String,
    },
    /// The line has too few or too many fields.
    #[error("line {line}: {found} fields are not the 6 of `{HEADER}`")]
    Fields {
        /// The line, from 1.
        line: u64,
        /// Its fields.
        found: usize,
    },
    /// A field is not what it has to be.
    #[error("line {line}, field {field}: `{found}` is not {right}")]
    Field {
        /// The line, from 1.
        line: u64,
        /// The name of the field.
        field: &'static str,
        /// The field.
        found: String,
        /// What would be right.
        right: &'static str,
    },
}

/// The commands of a file, each with its clock, line by line.
pub fn commands(file: impl BufRead) -> impl Iterator<Item = Result<(u64, Command), CsvError>> {
    let mut lines = (1..).zip(file.lines());
    let refused = match lines.next() {
        Some((_, Ok(header))) if header == HEADER => None,
        Some((_, Ok(header))) => Some(CsvError::Header { found: shown(&header) }),
        Some((line, Err(error))) => Some(CsvError::Read { line, error }),
        None => Some(CsvError::Header { found: String::new() }),
    };
    let commands = lines.map(|(line, text)| {
        let text = text.map_err(|error| CsvError::Read { line, error })?;
        parse(line, &text)
    });
    refused.map(Err).into_iter().chain(commands)
}

/// As much of a text as an error shows.
fn shown(text: &str) -> String {
    text.chars().take(SHOWN).collect()
}

fn parse(line: u64, text: &str) -> Result<(u64, Command), CsvError> {
    let fields: Vec<&str> = text.split(',').collect();
    let &[clock, command, bank, row, column, beats] = fields.as_slice() else {
        return Err(CsvError::Fields { line, found: fields.len() });
    };
    let wrong = |field, found: &str, right| CsvError::Field { line, field, found: shown(found), right };
    let number = |field, found: &str| match found.parse::<u64>() {
        Ok(number) if found.bytes().all(|digit| digit.is_ascii_digit()) => Ok(number),
        _ => Err(wrong(field, found, "a decimal number below 2^64")),
    };
    let empty = |field, found: &str| match found {
        "" => Ok(()),
        _ => Err(wrong(field, found, "empty, as it is for this command")),
    };
    let clock = number("clock", clock)?;
    let command = match command {
        "ACT" => {
            let (bank, row) = (number("bank", bank)?, number("row", row)?);
            empty("column", column)?;
            empty("beats", beats)?;
            Command::Activate { bank, row }
        }
        "RD" | "WR" => {
            let bank = number("bank", bank)?;
            let row = if row.is_empty() { None } else { Some(number("row", row)?) };
            let (column, beats) = (number("column", column)?, number("beats", beats)?);
            let burst = Burst { bank, row, column, beats };
            if command == "RD" { Command::Read(burst) } else { Command::Write(burst) }
        }
        "PRE" | "REF" => {
            let bank = match (command, bank) {
                (_, "all") => None,
                ("PRE", bank) => Some(number("bank", bank)?),
                (_, bank) => return Err(wrong("bank", bank, "`all`")),
            };
            empty("row", row)?;
            empty("column", column)?;
            empty("beats", beats)?;
            if command == "PRE" { Command::Precharge { bank } } else { Command::Refresh }
        }
        _ => return Err(wrong("command", command, "ACT, RD, WR, PRE or REF")),
    };
    Ok((clock, command))
}

impl Command {
    /// The command in CSV.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Activate { .. } => "ACT",
            Self::Read(_) => "RD",
            Self::Write(_) => "WR",
            Self::Precharge { .. } => "PRE",
            Self::Refresh => "REF",
        }
    }
}

impl fmt::Display for Command {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{},", self.name())?;
        match *self {
            Self::Activate { bank, row } => write!(f, "{bank},{row},,"),
            Self::Read(burst) | Self::Write(burst) => {
                let row = burst.row.map(|row| row.to_string()).unwrap_or_default();
                write!(f, "{},{row},{},{}", burst.bank, burst.column, burst.beats)
            }
            Self::Precharge { bank: Some(bank) } => write!(f, "{bank},,,"),
            Self::Precharge { bank: None } | Self::Refresh => f.write_str("all,,,"),
        }
    }
}
