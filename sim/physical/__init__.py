"""The physical truth layer: motions that bodies can make, from poses that a traffic simulator jots down."""
