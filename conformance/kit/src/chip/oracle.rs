//! The chip between events and the specification's chip as implementations.

use super::config::{self, Setting};
use super::request::{Request, push_answer};
use crate::error::Error;
use crate::implementation::Implementation;
use crate::kind::Oracle;
use saarcor_fast::chip::{ChipObserver, simulate_observed};
use saarcor_model::time::{Programs, TimingReport, simulate};

/// An oracle with the packets of the requests so far.
#[derive(Clone, Debug)]
pub struct ChipOracle {
    oracle: Oracle,
    /// The chip.
    pub setting: Setting,
    before: Programs,
    programs: Programs,
}

impl ChipOracle {
    /// The oracle of a configuration.
    ///
    /// # Errors
    /// The key whose value is wrong.
    pub fn new(oracle: Oracle, config: &str) -> Result<Self, Error> {
        let setting = config::parse(config)?;
        let programs = Programs { packets: Vec::new(), triangles: setting.triangles };
        Ok(Self { oracle, setting, before: programs.clone(), programs })
    }

    /// Takes what a request changes; a run changes nothing.
    pub fn change(&mut self, request: Request) {
        match request {
            Request::Before(operations) => self.before.packets.push(operations.into()),
            Request::Packet(operations) => self.programs.packets.push(operations.into()),
            Request::Run => {}
            Request::Flush => {
                self.before.packets.clear();
                self.programs.packets.clear();
            }
        }
    }

    /// Plays the packets on the chip between events.
    pub fn play(&self, observer: &mut impl ChipObserver) -> TimingReport {
        let before = std::slice::from_ref(&self.before);
        let report = simulate_observed(before, &self.programs, &self.setting.chip, observer);
        report.expect("the configuration was checked when it was read")
    }
}

impl Implementation for ChipOracle {
    fn observes(&self) -> String {
        "cycles,pci,mem,l1,l2".to_owned()
    }

    fn answer(&mut self, request: &[u8], answer: &mut Vec<u8>) -> Result<(), Error> {
        let request = Request::parse(request)?;
        request.fits(&self.setting)?;
        if request != Request::Run {
            self.change(request);
            answer.extend_from_slice(b"ok");
            return Ok(());
        }
        let report = match self.oracle {
            Oracle::Model => self.play(&mut ()),
            Oracle::Naive => {
                let before = std::slice::from_ref(&self.before);
                let report = simulate(before, &self.programs, &self.setting.chip);
                report.expect("the configuration was checked when it was read")
            }
        };
        push_answer(answer, &report);
        Ok(())
    }
}
