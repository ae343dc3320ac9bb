//! How much memory is left, to refuse what cannot fit before allocating it.

use std::fs::read_to_string;

/// Bytes that can still be allocated without swapping: the smaller of what the machine and what the
/// process's control group have left. Where neither can be told (off Linux) it is the address space.
///
/// It decides between an answer and an error only, never what the answer is.
pub fn available_memory() -> u64 {
    let machine = read_to_string("/proc/meminfo").ok().and_then(|text| meminfo_available(&text));
    let limit = number("/sys/fs/cgroup/memory.max");
    let group = limit.map(|max| max.saturating_sub(number("/sys/fs/cgroup/memory.current").unwrap_or(0)));
    machine.into_iter().chain(group).min().unwrap_or(isize::MAX as u64)
}

fn number(path: &str) -> Option<u64> {
    read_to_string(path).ok()?.trim().parse().ok()
}

fn meminfo_available(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_available_line_is_read_in_kilobytes() {
        let text = "MemTotal:       16000 kB\nMemFree: 1 kB\nMemAvailable:    2000 kB\n";
        assert_eq!(meminfo_available(text), Some(2000 * 1024));
        assert_eq!(meminfo_available("MemTotal: 3 kB"), None);
    }
}
