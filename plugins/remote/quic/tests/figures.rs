//! Figures over loopback, both ends in this process. Not a test: run it on a quiet machine with
//! `cargo test -p farlight_quic --test figures -- --ignored --nocapture`.

mod support;

use std::time::{Duration, Instant};

use farlight_wire::{Channel, Limits, LinkEvent};
use support::{End, Host, connect, join, noise, pair};

fn median(mut times: Vec<Duration>) -> (Duration, Duration) {
    times.sort();
    (times[times.len() / 2], times[times.len() * 99 / 100])
}

/// From sending in one end to having it in the other, and back.
fn round_trips(client: &mut End, server: &mut End, channel: Channel, bytes: usize) {
    let times = (0..500)
        .map(|i| {
            let start = Instant::now();
            client.send(channel, noise(i, bytes));
            let (_, message) = server.message();
            server.send(channel, message);
            client.message();
            start.elapsed()
        })
        .collect();
    let (middle, worst) = median(times);
    println!("{channel:?}, {bytes} bytes there and back: {middle:.0?} median, {worst:.0?} 99 %");
}

/// CPU time of the network thread so far.
#[cfg(target_os = "linux")]
fn cpu() -> Option<Duration> {
    let tasks = std::fs::read_dir("/proc/self/task").ok()?;
    let time = |task: std::path::PathBuf| {
        let name = std::fs::read_to_string(task.join("comm")).ok()?;
        let times = std::fs::read_to_string(task.join("schedstat")).ok()?;
        let time = times.split(' ').next()?.parse().ok()?;
        name.starts_with("farlight").then(|| Duration::from_nanos(time))
    };
    Some(tasks.filter_map(|task| time(task.ok()?.path())).sum())
}

#[cfg(not(target_os = "linux"))]
fn cpu() -> Option<Duration> {
    None
}

#[test]
#[ignore = "prints figures, which depend on the machine"]
fn loopback() {
    let mut host = Host::new();
    let times = (0..50)
        .map(|_| {
            let start = Instant::now();
            let mut client = connect(&host.invitation(), &Limits::default());
            client.opened();
            let time = start.elapsed();
            host.accept();
            time
        })
        .collect();
    let (middle, worst) = median(times);
    println!("connecting: {middle:.1?} median, {worst:.1?} 99 %");

    let (mut client, mut server) = join(&mut host);
    round_trips(&mut client, &mut server, Channel::Control, 100);
    round_trips(&mut client, &mut server, Channel::Latest, 20 << 10);

    for (channel, bytes) in [(Channel::Bulk, 256 << 10), (Channel::Latest, 1 << 20)] {
        // Confirmations of before.
        while client.event_within(Duration::from_millis(200)).is_some() {}
        let start = Instant::now();
        let (mut sent, mut received, mut flying) = (0, 0, 0);
        while received < 256 << 20 {
            while flying < 8 && sent < 256 << 20 {
                client.send(channel, vec![0; bytes]);
                sent += bytes;
                flying += 1;
            }
            while let Some(event) = client.link.poll() {
                flying -= usize::from(matches!(event, LinkEvent::Sent(_)));
            }
            while let Some(event) = server.event_within(Duration::from_millis(1)) {
                if let LinkEvent::Received(_, message) = event {
                    received += message.len();
                }
            }
        }
        let rate = received as f64 / 1e6 / start.elapsed().as_secs_f64();
        println!("{channel:?}, messages of {} KiB: {rate:.0} MB/s", bytes >> 10);
    }

    let before = cpu();
    std::thread::sleep(Duration::from_secs(10));
    match before.zip(cpu()) {
        Some((before, after)) => {
            println!("idle: {:.1?} of CPU time in 10 s, both ends", after - before);
        }
        None => println!("SKIPPED: CPU time is read on Linux only"),
    }
}

#[test]
#[ignore = "prints figures, which depend on the machine"]
fn control_beside_bulk() {
    let (_host, mut client, mut server) = pair();
    let mut times = Vec::new();
    let mut flying = 0;
    for _ in 0..200 {
        while flying < 8 {
            client.send(Channel::Bulk, vec![0; 256 << 10]);
            flying += 1;
        }
        let start = Instant::now();
        let id = client.send(Channel::Control, vec![1; 100]);
        loop {
            match server.event() {
                LinkEvent::Received(Channel::Control, _) => break,
                LinkEvent::Received(..) => flying -= 1,
                _ => {}
            }
        }
        times.push(start.elapsed());
        let _ = id;
        while client.link.poll().is_some() {}
    }
    let (middle, worst) = median(times);
    println!(
        "Control beside as much Bulk as there is room for: {middle:.1?} median, {worst:.1?} 99 %"
    );
}

/// Memory of the process, in KiB.
#[cfg(target_os = "linux")]
fn memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmRSS:"))?;
    line.split_whitespace().nth(1)?.parse().ok()
}

#[cfg(not(target_os = "linux"))]
fn memory() -> Option<u64> {
    None
}

#[test]
#[ignore = "prints figures, which depend on the machine"]
fn memory_over_many_connections() {
    let mut host = Host::new();
    for round in 0..8 {
        for i in 0..250 {
            let (mut client, mut server) = join(&mut host);
            client.send(Channel::Latest, noise(i, 100_000));
            server.message();
            // Some say goodbye, some vanish in the middle of a message.
            server.send(Channel::Bulk, noise(i, 200_000));
            if i % 2 == 0 {
                client.link.close(farlight_wire::CloseCode::Done, "");
                server.closed();
            }
        }
        match memory() {
            Some(memory) => println!("{} connections: {memory} KiB", (round + 1) * 250),
            None => println!("SKIPPED: memory is read on Linux only"),
        }
    }
}
