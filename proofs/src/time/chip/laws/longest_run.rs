//! The time that no run exceeds (CH-20).

use saarcor_model::time::{ChipConfig, Programs, SdramConfig, Version};

/// Cycles within which any run ends: those that it would take if each part of the chip waited for all others.
#[must_use]
pub fn longest_run(config: &ChipConfig, programs: &Programs) -> u64 {
    let SdramConfig { cycles_a_clock, beat_bytes, row_bytes, banks: _, .. } = config.sdram;
    let sdram = config.sdram;
    let opening = [sdram.ras_to_cas, sdram.precharge, sdram.row_active, sdram.row_cycle, sdram.row_to_row];
    let data = [sdram.cas, sdram.write_recovery];
    // A clock for each of its three commands, and one to come at.
    let a_job = opening.iter().chain(&data).map(|&clocks| u64::from(clocks)).sum::<u64>() + 4;
    let a_refresh = u64::from(sdram.precharge) + u64::from(sdram.refresh) + 2;
    // A transfer is a job a row, and one beat more than its bytes need.
    let transfer = |bytes: u64| {
        let jobs = bytes / u64::from(row_bytes) + 2;
        let clocks = jobs * a_job + bytes / u64::from(beat_bytes) + 2;
        let held_up = if sdram.refresh_interval == 0 { 1 } else { a_refresh + clocks };
        (clocks + a_refresh) * held_up * u64::from(cycles_a_clock)
    };
    let mut cycles = 16;
    let part = |bytes: u64| {
        let latency = 2 + u64::from(config.tag_latency);
        let vm_line = config.cache.geometry.line().0;
        let granule = u64::from(config.metadata_cache.granule);
        latency
            + transfer(bytes)
            + match config.version {
                Version::None => 0,
                Version::A => config.pci.cycles(vm_line) + transfer(vm_line),
                // The 5 bytes of each of 16 entries, and as many granules that they evict.
                Version::B => {
                    let granules = 2 * (5 * 16 / granule + 2);
                    config.pci.cycles(vm_line) + transfer(vm_line) + granules * transfer(granule)
                }
            }
    };
    for packet in &programs.packets {
        cycles += 2;
        for operation in packet.iter() {
            let (kind, l1) = (operation.unit as usize, config.l1[operation.unit as usize]);
            let lines = u64::from(operation.bytes) / u64::from(l1.line) + 2;
            let line = u64::from(l1.latency) + u64::from(config.return_latency) + 2;
            // At most two parts, as a line is no longer than one of the virtual memory.
            cycles += lines * (line + 2 * part(l1.line.into()));
            cycles += u64::from(operation.rays) + u64::from(config.units[kind].latency) + 2;
        }
    }
    cycles
}
