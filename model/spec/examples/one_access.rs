//! One access of the virtual memory: `cargo run -p saarcor-model --example one_access`.

use saarcor_model::vm::{
    Bytes, CacheConfig, Directory, Geometry, GeometryError, Hash, HostAddr, Policy, VirtualMemory,
};

fn main() -> Result<(), GeometryError> {
    // The PC's memory, and a card of 1 KiB: 4 sets of 4 lines of 64 bytes.
    let host: Vec<u8> = (0..=255).collect();
    let geometry = Geometry::new(Bytes(1024), Bytes(64), 4)?;
    let config = CacheConfig { geometry, hash: Hash::AddUpper, policy: Policy::Lru };
    let mut memory = VirtualMemory::new(Directory::<4>::new(config), host);

    let mut bytes = [0; 4];
    for addr in [100, 104, 200, 100] {
        let outcome = memory.read_in_line(HostAddr(addr), &mut bytes);
        println!("read {addr:3}: {bytes:3?}, {outcome:?}");
    }
    println!("{:?}", memory.directory.counters);
    Ok(())
}
