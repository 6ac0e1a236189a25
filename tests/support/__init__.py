"""What tests share: references in closed form and of other programs, small scenes, archives made by hand."""
