fn main() {
    let f = std::env::args().nth(1).unwrap();
    println!("{}", rpl_tests::run(&std::fs::read_to_string(f).unwrap()));
}
