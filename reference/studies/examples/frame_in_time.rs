//! A frame on the chip, cycle by cycle: `cargo run -p saarcor-studies --example frame_in_time`.

use saarcor_fast::chip::simulate;
use saarcor_model::time::Version;
use saarcor_studies::monitor::Silent;
use saarcor_studies::simulate::record;
use saarcor_studies::standard;
use saarcor_studies::trace::{PacketOrder, PacketSize, TraceOptions};
use saarcor_studies::world::{World, WorldOptions};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let world = World::open(&WorldOptions::new("pquake3"), &Silent)?;
    let options = TraceOptions { resolution: (320, 240), packet: PacketSize::Rays64, max_bounces: 5 };
    // Traced once, timed on three chips.
    let frame = record(&world, 556, &options, PacketOrder::Scan);
    for version in [Version::None, Version::A, Version::B] {
        let report = simulate(&[], &frame.programs, &standard::chip("pquake3", version)?)?;
        let (cycles, host, card) = (report.cycles, report.pci_bytes, report.memory_bytes());
        println!("{version:?}: {cycles} cycles, {host} bytes from the host, {card} bytes of on-board memory");
    }
    Ok(())
}
