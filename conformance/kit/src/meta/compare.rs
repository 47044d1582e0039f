//! Compares the answers of `saarcor-meta` with the model's.

use super::config::{self, MetaConfig};
use super::request::{Answer, Observes, Request};
use super::tags::{self, TagsAdapter};
use crate::comparison::{Comparison, Difference, Expected};
use crate::error::Error;
use crate::level::Level;
use crate::session::Session;
use saarcor_oracles::metadata::GranuleEvent;

/// The comparison of one session.
pub struct MetaComparison {
    config: MetaConfig,
    expected: Expected<TagsAdapter>,
    /// Metadata is corrupt: from then on a difference is an error that was not detected.
    corrupted: bool,
    /// Whether hits have differed: from then on all else has to differ.
    traffic_differs: bool,
}

impl MetaComparison {
    /// Compares what `observes` lists.
    ///
    /// # Errors
    /// What is wrong with the list or the configuration.
    pub fn new(session: &Session, observes: &str) -> Result<Self, Error> {
        let config = config::parse(session.config())?;
        let mut model = TagsAdapter::new(session.config(), &tags::model)?;
        model.observes = Observes::parse(observes)?;
        Ok(Self { config, expected: Expected::new(model), corrupted: false, traffic_differs: false })
    }

    /// The requirement of answers: version B's are version A's, and corrupt metadata is empty.
    fn answers(&self) -> &'static str {
        if self.corrupted { "VM-14" } else { "VM-13" }
    }

    fn state(&self, right: &Answer, got: &Answer) -> Option<String> {
        let geometry = self.config.cache.geometry;
        let (line, ways) = (geometry.line().0, u64::from(geometry.ways()));
        let place = |card: u64| {
            format!("set {:x}, way {:x}, byte {:x}", card / line / ways, card / line % ways, card % line)
        };
        if let (Some(right), Some(got)) = (right.card, got.card)
            && right != got
        {
            return Some(format!("{}; {} is right", place(got), place(right)));
        }
        let shown = |evicted: Option<u64>| evicted.map_or("none".to_owned(), |host| format!("{host:x}"));
        (right.evicted != got.evicted)
            .then(|| format!("line {} evicted; {} is right", shown(got.evicted), shown(right.evicted)))
    }
}

/// The first difference in what moved, and the requirement that it breaks.
fn moves(right: &[GranuleEvent], got: &[GranuleEvent], corrupted: bool) -> Option<(&'static str, String)> {
    let same = right.iter().zip(got).take_while(|(right, got)| right == got).count();
    let said = |moved: Option<&GranuleEvent>| match moved {
        None => "nothing more".to_owned(),
        Some(GranuleEvent::Found(granule)) => format!("granule {granule:x} in the metadata cache"),
        Some(GranuleEvent::Read(granule)) => format!("granule {granule:x} read from the card"),
        Some(GranuleEvent::WrittenBack(granule, _)) => format!("granule {granule:x} written back"),
    };
    let number = |moved: &GranuleEvent| match *moved {
        GranuleEvent::Found(granule)
        | GranuleEvent::Read(granule)
        | GranuleEvent::WrittenBack(granule, _) => granule,
    };
    let written_back = |moved: Option<&GranuleEvent>| matches!(moved, Some(GranuleEvent::WrittenBack(..)));
    match (right.get(same), got.get(same)) {
        (None, None) => None,
        (Some(GranuleEvent::WrittenBack(granule, right)), Some(GranuleEvent::WrittenBack(other, got)))
            if granule == other =>
        {
            let byte = right.iter().zip(got).take_while(|(right, got)| right == got).count();
            Some((
                if corrupted { "VM-14" } else { "VM-12" },
                format!("granule {granule:x} is written back with other bytes, from byte {byte} on"),
            ))
        }
        (right, got) => {
            let asked = |moved: Option<&GranuleEvent>| moved.filter(|_| !written_back(moved)).map(number);
            let requirement = match () {
                () if corrupted => "VM-14",
                // Which granules are requested, and when.
                () if !written_back(right) && !written_back(got) && asked(right) != asked(got) => "CH-17",
                () => "VM-13",
            };
            Some((requirement, format!("{}; {} is right", said(got), said(right))))
        }
    }
}

impl Comparison for MetaComparison {
    fn observed(&self, level: Level) -> bool {
        let Observes { hit, card, meta, .. } = self.expected.model.observes;
        match level {
            Level::Protocol => true,
            Level::Traffic => hit,
            Level::State => hit && card,
            Level::Metadata => hit && meta,
            _ => false,
        }
    }

    fn compare(
        &mut self,
        request: &[u8],
        answer: &[u8],
        found: &mut dyn FnMut(Difference),
    ) -> Result<(), Error> {
        let is_equal = self.expected.equals(request, answer)?;
        let request = Request::parse(request)?;
        self.corrupted |= matches!(request, Request::Flip { .. });
        if is_equal {
            return Ok(());
        }
        if matches!(request, Request::Flush | Request::Flip { .. }) {
            return Err("'ok' is right".into());
        }
        let right = Answer::parse(request, self.expected.answer(), self.expected.model.observes)?;
        let got = Answer::parse(request, answer, self.expected.model.observes)?;
        if self.traffic_differs {
            return Ok(());
        }
        let requirement = self.answers();
        if right.hit != got.hit {
            self.traffic_differs = true;
            let says =
                if got.hit == Some(true) { "a hit; a miss is right" } else { "a miss; a hit is right" };
            found(Difference { level: Level::Traffic, says: says.to_owned(), requirement });
            return Ok(());
        }
        if let Some(says) = self.state(&right, &got) {
            found(Difference { level: Level::State, says, requirement });
        }
        if let (Some(right), Some(got)) = (right.moved, got.moved)
            && let Some((requirement, says)) = moves(&right, &got, self.corrupted)
        {
            found(Difference { level: Level::Metadata, says, requirement });
        }
        Ok(())
    }

    fn expected(&self) -> &[u8] {
        self.expected.answer()
    }
}
