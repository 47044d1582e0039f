//! A conformance session, traced: `cargo run -p saarcor-kit --example traced_session`.

use saarcor_kit::error::Error;
use saarcor_kit::kind::{Kind, Oracle};
use saarcor_kit::level::Level;
use saarcor_kit::plan::sessions_named;
use saarcor_kit::scoreboard::check_answers;
use saarcor_kit::server::serve;
use saarcor_kit::sizes::Extent;

fn main() -> Result<(), Error> {
    let (kind, sessions) = sessions_named("vm/lru-victim", &Extent { seed: 0, requests: 0 })?;
    let session = &sessions[0];
    println!("{}: {}", session.name, session.idea);

    // The protocol around an implementation in process; yours takes the model's place.
    let model = |kind: &dyn Kind, config: &str| kind.oracle(Oracle::Model, config);
    let mut answers = Vec::new();
    serve(&model, &*session.text(), &mut answers).expect("memory can be written");

    let (sent, answered) = (session.text(), String::from_utf8_lossy(&answers));
    let requests = String::from_utf8_lossy(&sent);
    for (request, answer) in requests.lines().filter(|line| !line.starts_with('#')).zip(answered.lines()) {
        println!("-> {request:<56} <- {answer}");
    }
    let checked = check_answers(kind, session, &answers, Level::HIGHEST);
    println!("agrees up to level {}", checked.highest.map_or("none", Level::name));
    Ok(())
}
