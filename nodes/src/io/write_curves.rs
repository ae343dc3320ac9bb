//! Curves as JSON, CSV and SVG.

use std::fmt::Write as _;
use std::io::{self, Write};

use breccia_engine::{Data, Exporter, Sink, Value};
use serde_json::json;

use super::export::typed;
use crate::data::{Curves, Plot};

/// Exporters of curves.
pub(super) const EXPORTERS: &[Exporter] = &[
    Exporter {
        ty: Curves::TYPE,
        extensions: &["svg"],
        docs: "the plots under each other",
        write: |value, sink| write_file(value, sink, curves_svg),
    },
    Exporter {
        ty: Curves::TYPE,
        extensions: &["json"],
        docs: "object with the title and plots of series of points",
        write: |value, sink| write_file(value, sink, curves_json),
    },
    Exporter {
        ty: Curves::TYPE,
        extensions: &["csv"],
        docs: "table of plot, series, x and y with a header line",
        write: |value, sink| write_file(value, sink, curves_csv),
    },
];

fn write_file(value: &Value, sink: &mut Sink, text: fn(&Curves) -> String) -> io::Result<()> {
    let curves = typed::<Curves>(value)?;
    let mut out = sink.main()?;
    out.write_all(text(&curves).as_bytes())?;
    out.flush()
}

/// The curves as a JSON object `{title, plots: [{title, x, y, series: [{name, points: [[x, y]]}]}]}`.
pub fn curves_json(curves: &Curves) -> String {
    let plots = curves.plots.iter().map(|plot| {
        let series = plot.series.iter().map(|s| json!({ "name": s.name, "points": s.points }));
        json!({ "title": plot.title, "x": plot.x, "y": plot.y, "series": series.collect::<Vec<_>>() })
    });
    format!("{:#}\n", json!({ "title": curves.title, "plots": plots.collect::<Vec<_>>() }))
}

/// All points as CSV (RFC 4180) under the header `plot,series,x,y`.
pub fn curves_csv(curves: &Curves) -> String {
    let quote = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
    let mut text = "plot,series,x,y\r\n".to_owned();
    for plot in &curves.plots {
        for series in &plot.series {
            let names = format!("{},{}", quote(&plot.title), quote(&series.name));
            series.points.iter().for_each(|[x, y]| text += &format!("{names},{x},{y}\r\n"));
        }
    }
    text
}

/// The size of a plot in pixels.
const SIZE: [f64; 2] = [420.0, 260.0];
/// Left, top, right, bottom of the axes.
const FRAME: [f64; 4] = [56.0, 30.0, 410.0, 212.0];
/// Colours of the series that most people can tell apart (Okabe & Ito 2008), and dashes for those who cannot.
const STROKES: [(&str, &str); 6] = [
    ("#0072b2", ""),
    ("#d55e00", "6 3"),
    ("#111111", "2 2"),
    ("#009e73", "8 2 2 2"),
    ("#cc79a7", "1 2"),
    ("#e69f00", "10 4"),
];

/// All plots under each other.
fn curves_svg(curves: &Curves) -> String {
    let height = SIZE[1] * curves.plots.len().max(1) as f64;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {height}\" width=\"{0}\" height=\"{height}\">\n",
        SIZE[0]
    );
    for (i, plot) in curves.plots.iter().enumerate() {
        let _ = writeln!(svg, "<g transform=\"translate(0 {})\">\n{}</g>", SIZE[1] * i as f64, body(plot));
    }
    svg + "</svg>\n"
}

/// One plot as an SVG element: a line for each series, axes with round numbers, and a legend.
pub fn plot_svg(plot: &Plot) -> String {
    let [width, height] = SIZE;
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" \
         role=\"img\">\n{}</svg>\n",
        body(plot)
    )
}

fn body(plot: &Plot) -> String {
    let [left, top, right, bottom] = FRAME;
    let points = || plot.series.iter().flat_map(|s| &s.points).filter(|p| p.iter().all(|v| v.is_finite()));
    let range = |i: usize| {
        let (low, high) =
            points().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p[i]), h.max(p[i])));
        if low < high {
            [low, high]
        } else if low.is_finite() {
            [low - 0.5, low + 0.5]
        } else {
            [0.0, 1.0]
        }
    };
    let [x_range, [y_low, y_high]] = [range(0), range(1)];
    // Zero is worth seeing where it is near.
    let y_low = if y_low > 0.0 && y_low < 0.5 * y_high { 0.0 } else { y_low };
    let y_range = [y_low, y_high + 0.05 * (y_high - y_low)];
    let place = |value: f64, [low, high]: [f64; 2], from: f64, to: f64| {
        from + (value - low) / (high - low) * (to - from)
    };
    let (x, y) = (|v: f64| place(v, x_range, left, right), |v: f64| place(v, y_range, bottom, top));
    let mut svg = format!(
        "<text x=\"{left}\" y=\"16\" font-size=\"13\" font-weight=\"bold\">{}</text>\n\
         <rect x=\"{left}\" y=\"{top}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#999\"/>\n",
        escape(&plot.title),
        right - left,
        bottom - top
    );
    let mut line = |text: String| {
        svg += &text;
        svg.push('\n');
    };
    for tick in ticks(x_range) {
        let at = x(tick);
        line(format!("<path d=\"M{at:.1} {bottom}v4\" stroke=\"#999\"/>"));
        line(format!(
            "<text x=\"{at:.1}\" y=\"{:.1}\" font-size=\"10\" text-anchor=\"middle\">{}</text>",
            bottom + 15.0,
            number(tick)
        ));
    }
    for tick in ticks(y_range) {
        let at = y(tick);
        line(format!("<path d=\"M{left} {at:.1}H{right}\" stroke=\"#e4e4e4\"/>"));
        line(format!(
            "<text x=\"{:.1}\" y=\"{:.1}\" font-size=\"10\" text-anchor=\"end\">{}</text>",
            left - 5.0,
            at + 3.5,
            number(tick)
        ));
    }
    let middle = (left + right) / 2.0;
    line(format!(
        "<text x=\"{middle}\" y=\"{:.1}\" font-size=\"11\" text-anchor=\"middle\">{}</text>",
        bottom + 32.0,
        escape(&plot.x)
    ));
    let center = (top + bottom) / 2.0;
    line(format!(
        "<text transform=\"translate(12 {center}) rotate(-90)\" font-size=\"11\" text-anchor=\"middle\">{}</text>",
        escape(&plot.y)
    ));
    for (i, series) in plot.series.iter().enumerate() {
        let (color, dash) = STROKES[i % STROKES.len()];
        let stroke =
            format!("fill=\"none\" stroke=\"{color}\" stroke-width=\"1.6\" stroke-dasharray=\"{dash}\"");
        let shown = series.points.iter().filter(|p| p.iter().all(|v| v.is_finite()));
        let path: Vec<_> = shown.map(|p| format!("{:.1},{:.1}", x(p[0]), y(p[1]))).collect();
        line(format!("<polyline points=\"{}\" {stroke}/>", path.join(" ")));
        // The legend stands in a row under the axis, where no curve is.
        let at = left + i as f64 * (right - left) / plot.series.len().max(1) as f64;
        line(format!("<path d=\"M{at:.1} 253h18\" {stroke}/>"));
        line(format!(
            "<text x=\"{:.1}\" y=\"256\" font-size=\"10\">{}</text>",
            at + 22.0,
            escape(&series.name)
        ));
    }
    svg
}

/// Four to ten round numbers within a range.
fn ticks([low, high]: [f64; 2]) -> Vec<f64> {
    let rough = (high - low) / 5.0;
    let power = libm::pow(10.0, libm::floor(libm::log10(rough)));
    let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * power).find(|&s| s >= rough).unwrap_or(rough);
    let first = libm::ceil(low / step) as i64;
    (0..12).map(|i| (first + i) as f64 * step).take_while(|&tick| tick <= high + 1e-9 * step).collect()
}

/// A number with no more digits than needed.
fn number(value: f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// Text for XML and HTML, attributes included.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
        .replace('\'', "&#39;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Series;

    fn plot(points: &[[f64; 2]]) -> Plot {
        let series = Series { name: "a<b".into(), points: points.to_vec() };
        Plot::new("\"S\" & L", "lag", "value", vec![series])
    }

    #[test]
    fn plots_are_closed_elements_whatever_the_points() {
        let (nan, inf) = (f64::NAN, f64::INFINITY);
        for points in
            [&[][..], &[[0.0, 1.0]], &[[0.0, nan], [1.0, inf], [2.0, 3.0], [3.0, -1.0]], &[[1.0, 2.0]; 3]]
        {
            let svg = plot_svg(&plot(points));
            assert!(svg.starts_with("<svg") && svg.ends_with("</svg>\n"), "{svg}");
            assert!(!svg.contains("NaN") && !svg.contains("inf") && svg.contains("a&lt;b"), "{svg}");
            assert_eq!(svg.matches("<text").count(), svg.matches("</text>").count());
        }
    }

    #[test]
    fn ticks_are_round_and_within() {
        assert_eq!(ticks([0.0, 1.0]), [0.0, 0.2, 0.4, 0.6000000000000001, 0.8, 1.0]);
        assert_eq!(ticks([-3.0, 32.0]), [0.0, 10.0, 20.0, 30.0]);
        assert_eq!(number(0.6000000000000001), "0.6");
    }

    #[test]
    fn all_points_are_written() {
        let mut curves = Curves::new("quality");
        curves.plots.push(plot(&[[0.0, 1.0], [1.0, 0.25]]));
        assert_eq!(curves_csv(&curves).lines().nth(2), Some("\"\"\"S\"\" & L\",\"a<b\",1,0.25"));
        let json: serde_json::Value = serde_json::from_str(&curves_json(&curves)).unwrap();
        assert_eq!(json["plots"][0]["series"][0]["points"][1][1], 0.25);
        assert!(curves_svg(&curves).contains("polyline"));
    }
}
