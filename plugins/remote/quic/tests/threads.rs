//! Nothing is left when everything is dropped. Alone in its process, since it counts threads.

mod support;

use farlight_wire::Channel;

/// Threads of the network (Linux keeps 15 characters of a name).
#[cfg(target_os = "linux")]
fn threads() -> usize {
    let tasks = std::fs::read_dir("/proc/self/task").unwrap();
    let name = |task: std::fs::DirEntry| std::fs::read_to_string(task.path().join("comm"));
    tasks.filter_map(|task| name(task.ok()?).ok()).filter(|n| n.starts_with("farlight")).count()
}

#[cfg(target_os = "linux")]
#[test]
fn no_thread_outlives_the_links() {
    use std::time::{Duration, Instant};
    for round in 0..3 {
        assert_eq!(threads(), 0, "round {round}");
        let (host, mut client, mut server) = support::pair();
        assert!(threads() >= 1);
        client.send(Channel::Control, vec![round]);
        assert_eq!(server.message().1, [round]);
        match round {
            // In every order.
            0 => drop((host, client, server)),
            1 => drop((server, client, host)),
            _ => {
                client.link.close(farlight_wire::CloseCode::Done, "");
                drop((client, host));
                server.closed();
                drop(server);
            }
        }
        let start = Instant::now();
        while threads() > 0 {
            assert!(start.elapsed() < support::PATIENCE, "{} threads are left", threads());
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

#[cfg(not(target_os = "linux"))]
#[test]
fn no_thread_outlives_the_links() {
    println!("SKIPPED: threads are counted on Linux only");
    let (_host, mut client, mut server) = support::pair();
    client.send(Channel::Control, vec![1]);
    assert_eq!(server.message().1, [1]);
}
