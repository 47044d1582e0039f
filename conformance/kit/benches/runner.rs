//! Requests a second: the runner alone, with answers that are there already, and with the model and
//! the naive reference in process. One thread; making the sessions counts.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use saarcor_kit::deadline::Deadline;
use saarcor_kit::dut::{ConversationEnd, Dut, InProcess};
use saarcor_kit::error::Error;
use saarcor_kit::kind::{Kind as _, Oracle};
use saarcor_kit::level::Level;
use saarcor_kit::scoreboard::Scoreboard;
use saarcor_kit::server::serve;
use saarcor_kit::session::Session;
use saarcor_kit::vm::Vm;

const REQUESTS: usize = 50_000;
/// A session of the standard configuration.
const SEED: u64 = 3;

/// Gives answers that are there already: the null implementation.
struct Canned(Vec<u8>);

impl Dut for Canned {
    fn converse(
        &self,
        session: &Session,
        scoreboard: &mut Scoreboard<'_>,
        _: &Deadline,
    ) -> Result<ConversationEnd, Error> {
        for answer in self.0.split(|&byte| byte == b'\n').filter(|answer| !answer.is_empty()) {
            scoreboard.answer(answer, session.len());
        }
        Ok(ConversationEnd::default())
    }
}

fn runner(c: &mut Criterion) {
    let mut canned = Vec::new();
    let make = |kind: &dyn saarcor_kit::kind::Kind, config: &str| kind.oracle(Oracle::Model, config);
    serve(&make, &*Vm.random(SEED, REQUESTS).text(), &mut canned).expect("memory can be written");
    let duts: [(&str, Box<dyn Dut>); 3] = [
        ("null", Box::new(Canned(canned))),
        ("model", Box::new(InProcess::oracle(Oracle::Model))),
        ("naive", Box::new(InProcess::oracle(Oracle::Naive))),
    ];
    let mut group = c.benchmark_group("runner");
    group.throughput(Throughput::Elements(REQUESTS as u64));
    for (name, dut) in &duts {
        group.bench_function(*name, |b| {
            b.iter(|| {
                let session = Vm.random(SEED, REQUESTS);
                let mut scoreboard = Scoreboard::new(&Vm, &session, Level::HIGHEST);
                dut.converse(&session, &mut scoreboard, &Deadline::never()).expect("it runs");
                assert!(scoreboard.is_done() && scoreboard.findings().is_empty());
            });
        });
    }
    group.finish();
}

criterion_group!(benches, runner);
criterion_main!(benches);
