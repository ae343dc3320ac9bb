//! The same answer, however it is asked for.

use crate::support::Place;

/// The bytes of the array in an NPY file.
fn array(npy: &[u8]) -> &[u8] {
    let header = usize::from(u16::from_le_bytes([npy[8], npy[9]]));
    &npy[10 + header..]
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let place = Place::new();
    let run = |threads: &str| {
        let args = ["--no-cache", "--threads", threads, "--set", "size=24", "--out-dir", threads];
        place.run("lazy_volume", &args).expect(0, &[]);
        ["volume.npy", "preview.png", "sheet.png"].map(|name| place.read(&format!("{threads}/{name}")))
    };
    assert!(run("1") == run("2"));
}

#[test]
fn boxes_that_overlap_agree_bit_for_bit() {
    let place = Place::new();
    let (size, shift) = (20, [3, 7, 12]);
    let run = |origin: &str| {
        let origin = format!("origin={origin}");
        place
            .run("lazy_volume", &["--set", "size=20", "--set", &origin, "--output", "volume=v.npy"])
            .expect(0, &[]);
        place.read("v.npy")
    };
    let (a, b) = (run("(0,0,0)"), run("(3,7,12)"));
    let voxel = |npy: &[u8], [x, y, z]: [usize; 3]| {
        let at = ((z * size + y) * size + x) * 3;
        array(npy)[at..at + 3].to_vec()
    };
    for z in 0..size - shift[2] {
        for y in 0..size - shift[1] {
            for x in 0..size - shift[0] {
                assert_eq!(
                    voxel(&a, [x + shift[0], y + shift[1], z + shift[2]]),
                    voxel(&b, [x, y, z]),
                    "voxel {x} {y} {z}"
                );
            }
        }
    }
    assert!(a != b);
}

#[test]
fn seeds_differ() {
    let place = Place::new();
    for seed in ["1", "2"] {
        let output = format!("volume={seed}.npy");
        place.run("lazy_volume", &["--set", "size=8", "--seed", seed, "--output", &output]).expect(0, &[]);
    }
    assert!(place.read("1.npy") != place.read("2.npy"));
}
