use std::io::Cursor;

use flate2::read::GzDecoder;
use proptest::prelude::*;

use super::{bytes, export, floats, labels, volume};
use crate::data::{Map, Report, Row, Samples, Volume};
use crate::io::{
    Encoding, Integers, NrrdEncoding, ReadError, ReadLimits, VolumeOptions, atlas_grid, decode_image,
    decode_npy, decode_nrrd, range_text, report_csv, report_json, report_text, write_atlas, write_npy,
    write_nrrd, write_tiff,
};

fn npy_bytes(volume: &Volume) -> Vec<u8> {
    let mut out = Vec::new();
    write_npy(volume.size, &volume.maps[0], &mut out).unwrap();
    out
}

fn nrrd_bytes(volume: &Volume, encoding: NrrdEncoding) -> Vec<u8> {
    let mut out = Vec::new();
    write_nrrd(volume, &volume.maps[0], encoding, &mut out).unwrap();
    out
}

/// An NPY file made by hand.
fn npy(header: &str, data: &[u8]) -> Vec<u8> {
    let mut file = b"\x93NUMPY\x02\x00".to_vec();
    file.extend((header.len() as u32).to_le_bytes());
    file.extend(header.as_bytes());
    file.extend(data);
    file
}

fn read_npy(header: &str, data: &[u8]) -> Result<Volume, ReadError> {
    decode_npy(&npy(header, data), &VolumeOptions::default())
}

proptest! {
    #[test]
    fn arrays_come_back(
        size in prop::array::uniform3(1usize..6),
        channels in 1usize..6,
        kind in 0usize..3,
        spacing in prop::array::uniform3(1e-3f32..1e3),
        origin in prop::array::uniform3(-1000i32..1000),
    ) {
        let samples = [bytes, labels, floats][kind];
        let name = ["color", "label", "height"][kind];
        let mut expected = volume(size, name, channels, samples);
        (expected.spacing, expected.origin) = (spacing, origin);
        let options = VolumeOptions { map: name.to_owned(), ..VolumeOptions::default() };
        for encoding in [NrrdEncoding::Raw, NrrdEncoding::Gzip] {
            prop_assert_eq!(&decode_nrrd(&nrrd_bytes(&expected, encoding), &options).unwrap(), &expected);
        }
        (expected.spacing, expected.origin) = ([1.0; 3], [0; 3]);
        prop_assert_eq!(decode_npy(&npy_bytes(&expected), &options).unwrap(), expected);
    }
}

#[test]
fn npy_samples_start_at_a_multiple_of_64() {
    let file = npy_bytes(&volume([2, 3, 4], "color", 3, bytes));
    assert_eq!((file.len() - 72) % 64, 0);
    assert_eq!(file[file.len() - 73], b'\n');
}

#[test]
fn npy_fortran_order_is_turned() {
    // Shape (2, 1, 3): the first axis varies fastest.
    let header = "{'descr': '|u1', 'fortran_order': True, 'shape': (2, 1, 3), }";
    let found = read_npy(header, &[0, 10, 1, 11, 2, 12]).unwrap();
    assert_eq!(found.size, [3, 1, 2]);
    assert_eq!(found.maps[0].samples, Samples::U8(vec![0, 1, 2, 10, 11, 12]));
}

#[test]
fn npy_number_types_are_read() {
    let read = |descr: &str, data: &[u8]| {
        let header = format!("{{'shape':(1,1,1),'descr':'{descr}','fortran_order':False}}");
        read_npy(&header, data).map(|volume| (volume.maps[0].name.clone(), volume.maps[0].samples.clone()))
    };
    let value = |v: f32| Ok(("value".to_owned(), Samples::F32(vec![v])));
    let label = |v: u32| Ok(("label".to_owned(), Samples::U32(vec![v])));
    assert_eq!(read("|u1", &[7]), Ok(("value".to_owned(), Samples::U8(vec![7]))));
    assert_eq!(read("<u2", &[0xff, 0xff]), value(1.0));
    assert_eq!(read(">u2", &[0x00, 0xff]), value(255.0 / 65_535.0));
    assert_eq!(read("<f2", &[0x00, 0x3e]), value(1.5));
    assert_eq!(read(">f4", &1.25f32.to_be_bytes()), value(1.25));
    assert_eq!(read("<f8", &0.1f64.to_le_bytes()), value(0.1));
    assert_eq!(read("|b1", &[1]), label(1));
    assert_eq!(read("<u4", &[1, 2, 0, 0]), label(513));
    assert_eq!(read(">i8", &300i64.to_be_bytes()), label(300));
    for (descr, data, shown) in [
        ("<i2", &(-5i16).to_le_bytes()[..], "-5"),
        ("<u8", &(1u64 << 40).to_le_bytes(), "1099511627776"),
        ("<f4", &f32::NAN.to_le_bytes(), "NaN"),
        ("<f8", &1e300f64.to_le_bytes(), "1000000000"),
    ] {
        let error = read(descr, data).unwrap_err().to_string();
        assert!(error.contains("x 0, y 0, z 0, channel 0") && error.contains(shown), "{descr}: {error}");
    }
}

#[test]
fn integers_are_labels_on_request() {
    let file = npy("{'descr': '<u2', 'fortran_order': False, 'shape': (1, 1, 2)}", &[1, 0, 2, 1]);
    let options = VolumeOptions { integers: Integers::Labels, ..VolumeOptions::default() };
    assert_eq!(decode_npy(&file, &options).unwrap().maps[0].samples, Samples::U32(vec![1, 258]));
}

#[test]
fn npy_errors_say_what_was_found() {
    let cases = [
        ("{'descr': '<c8', 'fortran_order': False, 'shape': (1, 1, 1)}", "\"<c8\""),
        ("{'descr': [('r', '|u1')], 'fortran_order': False, 'shape': (1,)}", "records"),
        ("{'descr': '|u1', 'fortran_order': False, 'shape': (4, 4)}", "[4, 4]"),
        ("{'descr': '|u1', 'fortran_order': False, 'shape': (0, 4, 4)}", "4 × 4 × 0"),
        (
            "{'descr': '|u1', 'fortran_order': False, 'shape': (4, 4, 4)}",
            "expected 64 bytes of samples, found 2",
        ),
        ("{'descr': '|u1', 'fortran_order': Maybe, 'shape': (4, 4, 4)}", "Maybe"),
        ("{'descr': '|u1', 'shape': (4, 4, 4)}", "lacks `fortran_order`"),
        ("{'descr': '|u1', 'fortran_order': False, 'shape': (-1, 4, 4)}", "length is expected"),
        (
            "{'descr': '|u1', 'fortran_order': False, 'shape': (100000, 100000, 100000)}",
            "100000 × 100000 × 100000",
        ),
        (
            "{'descr': '<f8', 'fortran_order': False, 'shape': (9999999999999, 9999999999999, 3)}",
            "9999999999999 × 9999999999999",
        ),
    ];
    for (header, shown) in cases {
        let error = read_npy(header, &[1, 2]).unwrap_err().to_string();
        assert!(error.contains(shown), "{header}: {error}");
    }
}

#[test]
fn nrrd_of_other_programs_is_read() {
    // Planes of channels, big-endian, spacings instead of directions, comments and unknown fields.
    let mut file = b"NRRD0004\r\n# comment\r\ntype: unsigned short\r\ncontent: something\r\ndimension: 4\r\n\
        sizes: 2 1 1 2\r\nspacings: 0.5 2 3 nan\r\nkinds: space space space vector\r\nendian: big\r\n\
        encoding: raw\r\nkey:=value\r\n\r\n"
        .to_vec();
    file.extend([0x00, 0x01, 0x00, 0x02, 0xff, 0xff, 0x00, 0x00]);
    let found = decode_nrrd(&file, &VolumeOptions::default()).unwrap();
    assert_eq!((found.size, found.spacing), ([2, 1, 1], [0.5, 2.0, 3.0]));
    let n = 65_535.0;
    assert_eq!(found.maps[0].samples, Samples::F32(vec![1.0 / n, 1.0, 2.0 / n, 0.0]));
}

#[test]
fn nrrd_errors_say_what_was_found() {
    let head = "NRRD0005\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n";
    let cases = [
        (head.replace("raw", "bzip2"), "\"bzip2\""),
        (head.replace("uint8", "block"), "\"block\""),
        (head.replace("uint8", "float"), "`endian` is missing"),
        (head.replace("2 2 2", "2 2"), "`sizes` are \"2 2\""),
        (head.replace("2 2 2", "2 -2 2"), "`sizes` are \"2 -2 2\""),
        (head.replace("2 2 2", "2000000 2000000 2000000"), "2000000 × 2000000 × 2000000"),
        (head.replace("sizes", "size"), "lacks `sizes`"),
        (format!("{head}data file: other.raw\n"), "\"other.raw\""),
        (format!("{head}space origin: (a,b)\n"), "(a,b)"),
        (head.to_owned(), "expected 8 bytes of samples, found 7"),
        (head.replace("raw", "gzip"), "gzip"),
    ];
    for (header, shown) in cases {
        let data = if shown.contains("found 7") { 7 } else { 8 };
        let mut file = format!("{header}\n").into_bytes();
        file.extend(std::iter::repeat_n(0, data));
        let error = decode_nrrd(&file, &VolumeOptions::default()).unwrap_err().to_string();
        assert!(error.contains(shown), "{header}: {error}");
    }
}

#[test]
fn a_compressed_bomb_is_cut_at_its_promise() {
    let mut file = b"NRRD0005\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: gzip\n\n".to_vec();
    let zeros = std::io::repeat(0);
    std::io::Read::read_to_end(
        &mut flate2::read::GzEncoder::new(std::io::Read::take(zeros, 1 << 26), flate2::Compression::fast()),
        &mut file,
    )
    .unwrap();
    let found = decode_nrrd(&file, &VolumeOptions::default()).unwrap();
    assert_eq!(found.maps[0].samples, Samples::U8(vec![0; 8]));
}

#[test]
fn limits_are_checked_before_samples_are_missed() {
    let limits = ReadLimits { volume_bytes: 1000, ..ReadLimits::default() };
    let options = VolumeOptions { limits, ..VolumeOptions::default() };
    let file = npy("{'descr': '<f4', 'fortran_order': False, 'shape': (10, 10, 10)}", &[]);
    let error = decode_npy(&file, &options).unwrap_err();
    assert!(matches!(error, ReadError::TooLarge { bytes: 4000, limit: 1000, .. }), "{error}");
}

fn material() -> Volume {
    let mut all = volume([5, 4, 3], "color", 3, bytes);
    all.maps.push(Map { name: "label".to_owned(), channels: 1, samples: labels(60) });
    all.maps.push(Map { name: "height".to_owned(), channels: 1, samples: floats(60) });
    all
}

#[test]
fn each_further_map_gets_a_file_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    for extension in ["npy", "nrrd", "tif", "tiff", "png"] {
        let target = folder.path().join(format!("rock.{extension}"));
        let files = export(material(), &target, extension).unwrap();
        let names: Vec<_> =
            files.iter().map(|f| f.file_name().unwrap().to_string_lossy().into_owned()).collect();
        let expected = ["rock", "rock.label", "rock.height"].map(|name| format!("{name}.{extension}"));
        assert_eq!(names, expected);
        assert!(files.iter().all(|file| file.metadata().unwrap().len() > 60));
    }
    let heights = std::fs::read(folder.path().join("rock.height.nrrd")).unwrap();
    let heights = decode_nrrd(&heights, &VolumeOptions::default()).unwrap();
    assert_eq!((heights.origin, heights.spacing), ([-3, 0, 7], [0.5, 0.25, 2.0]));
    assert_eq!(heights.maps[0].samples, floats(60));
}

#[test]
fn a_folder_holds_slices_and_their_description() {
    let folder = tempfile::tempdir().unwrap();
    let files = export(material(), &folder.path().join("rock/"), "/").unwrap();
    assert_eq!(files.len(), 3 * 3 + 1);
    let about = std::fs::read(folder.path().join("rock/volume.json")).unwrap();
    let about: serde_json::Value = serde_json::from_slice(&about).unwrap();
    assert_eq!(about["size"], serde_json::json!([5, 4, 3]));
    assert_eq!(about["origin"], serde_json::json!([-3, 0, 7]));
    assert_eq!(about["spacing"], serde_json::json!([0.5, 0.25, 2.0]));
    assert_eq!(about["maps"][0]["files"], "color_%04d.png");
    assert_eq!(about["maps"][1]["bits"], 16);

    let read = |name: &str| {
        let file = std::fs::read(folder.path().join("rock").join(name)).unwrap();
        decode_image(&file, Encoding::Data, &ReadLimits::default()).unwrap()
    };
    let all = material();
    let (color, label, height) = (read("color_0002.png"), read("label_0001.png"), read("height_0002.png"));
    let [lo, hi] = [0, 1].map(|i| about["maps"][2]["range"][i].as_f64().unwrap() as f32);
    for y in 0..4 {
        for x in 0..5 {
            let (top, middle) = (all.index(x, y, 2), all.index(x, y, 1));
            let (px, py) = (x as u32, y as u32);
            let rgb = [0, 1, 2].map(|c| all.maps[0].samples.get_u8(top * 3 + c));
            assert_eq!(color.rgb8(px, py), rgb);
            assert_eq!((label.get(px, py, 0) * 65_535.0).round(), all.maps[1].samples.get(middle));
            let value = lo + (hi - lo) * height.get(px, py, 0);
            assert!((value - all.maps[2].samples.get(top)).abs() <= (hi - lo) / 255.0 * 0.51);
        }
    }
}

#[test]
fn an_atlas_holds_slice_after_slice() {
    let all = volume([3, 2, 5], "color", 3, bytes);
    let mut file = Vec::new();
    write_atlas(&all, &all.maps[0], &mut file).unwrap();
    let image = decode_image(&file, Encoding::Auto, &ReadLimits::default()).unwrap();
    let [columns, rows] = atlas_grid(all.size);
    assert_eq!((image.width() as usize, image.height() as usize), (3 * columns, 2 * rows));
    for z in 0..columns * rows {
        for (x, y) in (0..3).flat_map(|x| (0..2).map(move |y| (x, y))) {
            let found = image.rgb8((z % columns * 3 + x) as u32, (z / columns * 2 + y) as u32);
            let expected = match z {
                0..5 => [0, 1, 2].map(|c| all.maps[0].samples.get_u8(all.index(x, y, z) * 3 + c)),
                _ => [0; 3],
            };
            assert_eq!(found, expected, "slice {z}, x {x}, y {y}");
        }
    }
    let reader = png::Decoder::new(Cursor::new(&file)).read_info().unwrap();
    let text = &reader.info().uncompressed_latin1_text[0];
    let about: serde_json::Value = serde_json::from_str(&text.text).unwrap();
    assert_eq!((text.keyword.as_str(), &about["columns"]), ("Description", &serde_json::json!(columns)));
}

#[test]
fn atlases_are_as_square_as_can_be() {
    assert_eq!(atlas_grid([64, 64, 64]), [8, 8]);
    assert_eq!(atlas_grid([128, 128, 128]), [11, 12]);
    assert_eq!(atlas_grid([100, 10, 10]), [1, 10]);
    assert_eq!(atlas_grid([1, 1, 1]), [1, 1]);
}

#[test]
fn tiff_pages_are_slices() {
    let wide = |n: usize| Samples::U32((0..n as u32).map(|i| i * 70_000).collect());
    for (name, channels, samples) in [
        ("color", 3, bytes as fn(usize) -> Samples),
        ("color", 4, bytes),
        ("pair", 2, bytes),
        ("value", 1, bytes),
        ("label", 1, labels),
        ("label", 1, wide),
    ] {
        let all = volume([5, 4, 3], name, channels, samples);
        let mut file = Cursor::new(Vec::new());
        write_tiff(&all, &all.maps[0], &mut file).unwrap();
        file.set_position(0);
        let mut decoder = tiff::decoder::Decoder::new(file).unwrap();
        let text = decoder.get_tag_ascii_string(tiff::tags::Tag::ImageDescription).unwrap();
        assert!(text.contains("slices=3\n") && text.contains("spacing=2\n"), "{text}");
        for z in 0..3 {
            let page: Vec<u32> = match decoder.read_image().unwrap() {
                tiff::decoder::DecodingResult::U8(v) => v.into_iter().map(u32::from).collect(),
                tiff::decoder::DecodingResult::U16(v) => v.into_iter().map(u32::from).collect(),
                tiff::decoder::DecodingResult::U32(v) => v,
                other => panic!("{other:?}"),
            };
            let n = 20 * channels;
            let expected: Vec<u32> = match &all.maps[0].samples {
                Samples::U8(v) => v[z * n..][..n].iter().map(|&v| v.into()).collect(),
                Samples::U32(v) => v[z * n..][..n].to_vec(),
                Samples::F32(_) => Vec::new(),
            };
            assert_eq!(page, expected, "{name} {channels}, page {z}");
            assert_eq!(decoder.more_images(), z < 2);
            if z < 2 {
                decoder.next_image().unwrap();
            }
        }
    }
}

#[test]
fn only_stacks_larger_than_their_tags_claim_to_be_of_imagej() {
    for (size, expected) in [([16, 16, 16], true), ([5, 4, 3], false), ([400, 400, 1], false)] {
        let all = volume(size, "value", 1, bytes);
        let mut file = Vec::new();
        write_tiff(&all, &all.maps[0], &mut Cursor::new(&mut file)).unwrap();
        assert_eq!(file.windows(7).any(|part| part == b"ImageJ="), expected, "{size:?}");
    }
}

#[test]
fn what_a_format_cannot_hold_is_refused_with_one_that_can() {
    let folder = tempfile::tempdir().unwrap();
    let big = volume([2, 2, 1], "label", 1, |n| Samples::U32(vec![70_000; n]));
    let error = export(big, &folder.path().join("a.png"), "png").unwrap_err().to_string();
    assert!(error.contains("70000") && error.contains("nrrd"), "{error}");
    let many = volume([2, 2, 1], "value", 5, bytes);
    let error = export(many, &folder.path().join("a.tif"), "tif").unwrap_err().to_string();
    assert!(error.contains("5 channels") && error.contains("npy"), "{error}");
    let mut broken = volume([2, 2, 1], "value", 1, bytes);
    broken.size = [3, 2, 1];
    let error = export(broken, &folder.path().join("a.npy"), "npy").unwrap_err().to_string();
    assert!(error.contains("3 × 2 × 1") && error.contains("4 samples"), "{error}");
    let mut twins = material();
    twins.maps[1].name = "a/b".to_owned();
    twins.maps[2].name = "a b".to_owned();
    let error = export(twins, &folder.path().join("a.npy"), "npy").unwrap_err().to_string();
    assert!(error.contains("`a/b`") && error.contains("`a b`"), "{error}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "a failed export leaves nothing");
}

#[test]
fn nrrd_gzip_holds_the_samples() {
    let all = volume([5, 4, 3], "color", 3, bytes);
    let file = nrrd_bytes(&all, NrrdEncoding::Gzip);
    let at = file.windows(2).position(|pair| pair == b"\n\n").unwrap() + 2;
    let mut inflated = Vec::new();
    std::io::Read::read_to_end(&mut GzDecoder::new(&file[at..]), &mut inflated).unwrap();
    assert_eq!(Samples::U8(inflated), bytes(180));
}

#[test]
fn reports_tell_references_and_ranges() {
    let mut report = Report::new("quality");
    let row = Row {
        name: "a".into(),
        value: 0.5,
        unit: "nats".into(),
        reference: Some(0.25),
        good: Some([0.0, 1.5]),
    };
    report.rows.push(row.clone());
    report.rows.push(Row { name: "bc".into(), value: 3.0, good: Some([0.8, f64::INFINITY]), ..row.clone() });
    report.rows.push(Row { name: "d".into(), value: -2.0, reference: None, good: Some([-1.0, 1.0]), ..row });
    assert_eq!(
        report_text(&report),
        "quality\n\
         a   0.5000    (0.2500)  good up to 1.5  nats\n\
         bc       3    (0.2500)  good from 0.8   nats\n\
         d       -2 !            good -1 to 1    nats\n"
    );
    let json: serde_json::Value = serde_json::from_str(&report_json(&report)).unwrap();
    assert_eq!(json["rows"][1]["good"], serde_json::json!([0.8, null]));
    assert_eq!((&json["rows"][2]["flagged"], &json["rows"][0]["reference"]), (&true.into(), &0.25.into()));
    assert!(report_csv(&report).contains("\nd,-2,nats,,-1,1\r\n"));
    assert_eq!(range_text([0.01, 0.025]), "0.01 to 0.025");
}

#[test]
fn reports_are_tables() {
    let mut report = Report::new("candidates");
    report.row("kept, in all", 12.0, "").row("say \"mean\"", f64::NAN, "levels");
    assert_eq!(
        report_csv(&report),
        "name,value,unit,reference,low,high\r\n\"kept, in all\",12,,,,\r\n\"say \"\"mean\"\"\",NaN,levels,,,\r\n"
    );
    assert_eq!(report_text(&report), "candidates\nkept, in all   12\nsay \"mean\"    NaN  levels\n");
    let folder = tempfile::tempdir().unwrap();
    export(report, &folder.path().join("r.json"), "json").unwrap();
    let json: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folder.path().join("r.json")).unwrap()).unwrap();
    assert_eq!(json["rows"][0]["value"], 12.0);
    assert_eq!(json["rows"][1]["value"], serde_json::Value::Null);
}
