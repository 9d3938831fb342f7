"""What waves meet: materials, reflection, transmission, wedges, and a scene at one frequency."""
